"""Populations: many simulated trials of one agent under one condition, without records.

Precise curves need thousands of trials per point. The results equal those of the same trials played by
:func:`lockprobe.run_trial`. With the extra ``fast`` the loop is compiled.
"""

from __future__ import annotations

import os
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.policy import Policy
from lockprobe.boxes.box import Lockbox, Shuffle
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_number, check_whole
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.simulation.exact.condition_chances import told_by
from lockprobe.simulation.montecarlo import rules
from lockprobe.simulation.montecarlo.compiled import (
    compiled,
    deepest,
    fill,
    jumps,
    lasting_in,
    numbers_a_step,
    pays,
    play_blind,
    rule_of,
    scene_of,
)
from lockprobe.simulation.montecarlo.compiled_choices import RANDOM, play_trials
from lockprobe.simulation.montecarlo.plain import BoxWorld, heeds_order, play_plainly, policy_of, world_of
from lockprobe.simulation.montecarlo.rules import Rule
from lockprobe.simulation.montecarlo.streams import Counted, FromTree, LuckSource, order_of
from lockprobe.statistics.loops import LoopMeasures, measure

Streams = Literal["study", "fast"]
"""``study``: trial i is trial i of a study with this seed. ``fast``: counter-based random numbers."""

MOST_TRIALS = 100_000_000
MOST_RECORDED = 1_000_000_000
PIECE = 40_000
"""Steps played in one call."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Population:
    """The outcomes of many trials of one agent under one condition; columns have one row per trial.

    Attributes:
        agent: Agent spec, or the name of its class.
        world: The box, its reports and the budget.
        solved: Whether the target moved, shape (trials,).
        steps: Steps played, shape (trials,).
        actions: Joints attempted, by index in panel order, -1 after the end, shape (trials, budget); None if not
            recorded.
        moved: Whether each joint moved, the same shape; False after the end.
        told_moved: The reported outcomes, the same shape.
    """

    agent: str
    world: BoxWorld
    solved: NDArray[np.bool_]
    steps: NDArray[np.int32]
    actions: NDArray[np.int8] | None = None
    moved: NDArray[np.bool_] | None = None
    told_moved: NDArray[np.bool_] | None = None

    def __len__(self) -> int:
        return len(self.solved)

    @property
    def success(self) -> float:
        """Share of trials solved, [0, 1]."""
        return float(self.solved.mean())

    @property
    def curve(self) -> NDArray[np.float64]:
        """Share of trials solved by step 0, 1, ..., shape (budget + 1,)."""
        ends = np.bincount(self.steps[self.solved], minlength=self.world.budget + 1)
        return np.asarray(np.cumsum(ends) / len(self), np.float64)

    def loops(self, *, overlap: bool = False, min_length: int = 3) -> LoopMeasures:
        """The loop measures of each trial; see :func:`lockprobe.statistics.loops.measure`.

        Raises:
            BadValue: If no actions were recorded.
        """
        if self.actions is None:
            raise BadValue("record", False, "a population with its actions recorded")
        played = [row[:steps] for row, steps in zip(self.actions, self.steps, strict=True)]
        return measure(played, overlap=overlap, min_length=min_length)


def population(
    agent: str | Policy[Any] = "random",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    flip: FlipKind | OutcomeFlip = DEFAULT,
    modality: str | None = None,
    trials: int = 5_000,
    seed: int = 1,
    repetition: int = 1,
    max_steps: int = 20,
    shuffle: Shuffle = "trial",
    streams: Streams = "study",
    record: bool = False,
    threads: int | None = None,
) -> Population:
    """Play many trials of one agent under one condition.

    With ``streams="study"`` trial i equals ``run_trial(..., trial=i)``, action by action and report by report (rows
    start at 0, trials at 1). With ``fast`` it is another draw from the same distribution, and the population may be
    very large. The layout of the panel is fixed.

    Args:
        agent: Spec of an agent that is a policy, or a policy.
        box: Name of a box, path of a TOML file, or a box.
        p: Flip probability, [0, 1].
        flip: What a false report is: a word, or a flip of every report, whose rate does not count.
        modality: As for :func:`lockprobe.propagate`: ``symbolic?tell=state``, or ``symbolic``, with outcomes too.
        trials: Number of trials.
        seed: Seed of the study.
        repetition: Repetition of the study, from 1; only for ``streams="study"``.
        max_steps: Budget in steps.
        shuffle: How often the order of the list is drawn: in every ``trial``, once for the ``study``, ``never``.
        streams: Source of the random numbers.
        record: Whether actions and outcomes are kept.
        threads: Number of threads; by default the number of processors. It changes no result.

    Raises:
        UserMistake: If a name does not exist, or a value is out of range.

    >>> population("round-robin", trials=100).success
    1.0
    """
    _check(trials, repetition, seed, streams, shuffle, threads, p)
    policy, tell = policy_of(agent), told_by(modality, "memoryless" if isinstance(flip, OutcomeFlip) else flip)
    like, order = flip if isinstance(flip, OutcomeFlip) else flip_of(flip), order_of(find_box(box), shuffle, seed)
    world = world_of(box, flip=like.at_rate(p), max_steps=max_steps, tell=tell)
    if record and trials * max_steps > MOST_RECORDED:
        raise BadValue("steps to record", trials * max_steps, f"at most {MOST_RECORDED}")
    found = _empty_columns(trials, max_steps if record else 0)
    _play(policy, world, found, threads, streams=streams, seed=seed, repetition=repetition, order=order)
    return Population(
        agent=agent if isinstance(agent, str) else type(policy).__name__,
        world=world,
        solved=found.solved,
        steps=found.steps,
        actions=found.actions if record else None,
        moved=found.moved if record else None,
        told_moved=found.told_moved if record else None,
    )


def _check(trials: int, repetition: int, seed: int, streams: str, shuffle: str, threads: int | None, p: float) -> None:
    check_number("flip rate p", p)
    check_choice("streams", streams, get_args(Streams))
    check_choice("shuffle", shuffle, get_args(Shuffle))
    check_whole("trials", trials, 1, MOST_TRIALS)
    check_whole("repetition", repetition, 1)
    check_whole("seed", seed, 0)
    if threads is not None:
        check_whole("threads", threads, 1)


class _Columns(NamedTuple):
    steps: NDArray[np.int32]
    solved: NDArray[np.bool_]
    actions: NDArray[np.int8]
    moved: NDArray[np.bool_]
    told_moved: NDArray[np.bool_]


def _empty_columns(trials: int, columns: int) -> _Columns:
    return _Columns(
        steps=np.zeros(trials, np.int32),
        solved=np.zeros(trials, bool),
        actions=np.full((trials, columns), -1, np.int8),
        moved=np.zeros((trials, columns), bool),
        told_moved=np.zeros((trials, columns), bool),
    )


def _play(
    policy: Policy[Any],
    world: BoxWorld,
    found: _Columns,
    threads: int | None,
    *,
    streams: Streams,
    seed: int,
    repetition: int,
    order: tuple[int, ...] | None,
) -> None:
    """Play the trials by the fastest available method, with as many random numbers as this policy can need."""
    rule = rule_of(policy)
    swift = rule is not None and pays(len(found.steps) * world.budget)
    joints, flips = len(world.places), world.budget if world.flip.p or not swift else 0
    draws = 0 if rule is None else world.budget * numbers_a_step(rule)
    source: LuckSource
    if streams == "study":
        source = FromTree(seed, repetition, joints, order=order, flips=flips, draws=draws)
    elif rule is None:
        raise BadValue("streams", streams, f"study, since {type(policy).__name__} is none that is compiled")
    else:
        source = Counted(
            seed,
            joints,
            order=order if heeds_order(policy) else tuple(range(joints)),
            flips=flips,
            draws=draws,
            depth=deepest(joints) if rule.kind == RANDOM else 0,
            fill=compiled(fill) if swift else None,
        )
    if rule is not None and swift:
        _play_compiled(world, rule, source, found, threads or os.cpu_count() or 1)
    else:
        _play_plainly(policy, world, source, found)


def _play_plainly(policy: Policy[Any], world: BoxWorld, source: LuckSource, found: _Columns) -> None:
    """Play one trial after another in Python."""
    for trial in range(len(found.steps)):
        played = play_plainly(policy, world, *source.luck(trial))
        steps = len(played.joints)
        found.steps[trial], found.solved[trial] = steps, played.solved
        if found.actions.shape[1]:
            found.actions[trial, :steps] = played.joints
            found.moved[trial, :steps] = played.moved
            found.told_moved[trial, :steps] = played.told_moved


def _play_compiled(world: BoxWorld, rule: Rule, source: LuckSource, found: _Columns, threads: int) -> None:
    """Play many trials per compiled call, with several threads if Python has to set up no streams."""
    scene, trials = scene_of(world), max(1, PIECE // world.budget)
    if isinstance(source, Counted) and rule.kind == RANDOM and not found.actions.shape[1]:
        blind, depth, trials = compiled(play_blind), deepest(scene.joints), 32 * trials
        jump = jumps(scene, depth)

        def piece(first: int) -> None:
            blind(source.key, first, world.budget, jump, depth, *_rows(found, first, trials)[:2])
    else:
        play = compiled(play_trials)

        def piece(first: int) -> None:
            steps, solved, actions, moved, told_moved = _rows(found, first, trials)
            orders, flips, draws = source.block(first, len(steps))
            room, lasting = rules.record(rules.MEMORY), lasting_in(flips, orders, world.flip)
            play(scene, rule, room, orders, flips, lasting, draws, steps, solved, actions, moved, told_moved)

    piece(0)  # compiles, once
    others = range(trials, len(found.steps), trials)
    if threads == 1 or isinstance(source, FromTree):
        deque(map(piece, others), maxlen=0)
    else:
        with ThreadPoolExecutor(max_workers=threads) as pool:
            deque(pool.map(piece, others), maxlen=0)


def _rows(found: _Columns, first: int, trials: int) -> _Columns:
    """The rows of this many trials, from ``first`` on."""
    rows = slice(first, first + trials)
    return _Columns(
        found.steps[rows], found.solved[rows], found.actions[rows], found.moved[rows], found.told_moved[rows]
    )
