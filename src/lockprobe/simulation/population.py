"""Populations: many simulated trials of one agent under one condition, without records.

Precise curves need thousands of trials per point. Trial i equals that of :func:`lockprobe.run_trial`, alone or among a
million, since luck has addresses (:mod:`lockprobe.trial.luck`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.policy import Policy
from lockprobe.boxes.box import Lockbox, Shuffle
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice, check_whole
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.simulation.kernel import Boxes, Flags, Minds, Whole, World, policy_of, what_is_told, world_of
from lockprobe.statistics.loops import onset
from lockprobe.trial.luck import numbers
from lockprobe.trial.plan import drawn_orders, orders_of_study

MOST_STEPS = 1_000_000_000
"""Three bytes each are kept."""

PIECE = 8_192
"""Trials played at once: their numbers fit into the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """The outcomes of many trials of one agent under one condition; columns have one row per trial.

    Attributes:
        solved, steps: Whether the target moved, and the steps played, shape (trials,).
        actions: Joints attempted, by index in panel order, -1 after the end, shape (trials, budget).
        moved, told_moved: Whether each joint moved, and is reported to have, the same shape; False after the end.
        agent: Its spec, or the name of its class.
        world: The box, its reports and the budget.
    """

    solved: Flags
    steps: NDArray[np.int32]
    actions: NDArray[np.int8]
    moved: Flags
    told_moved: Flags
    agent: str
    world: World

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

    def loops(self) -> NDArray[np.bool_]:
        """Whether each trial holds an action loop."""
        played = (row[:steps].tolist() for row, steps in zip(self.actions, self.steps, strict=True))
        return np.array([onset(actions) > 0 for actions in played])


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
) -> Population:
    """Play many trials of one agent under one condition.

    Trial i equals ``run_trial(..., trial=i)``, action by action and report by report (rows start at 0, trials at 1).
    The layout of the panel is fixed.

    >>> population("round-robin", trials=100).success
    1.0

    Args:
        agent: Spec of an agent that is a policy, or a policy.
        box: Name of a box, path of a TOML file, or a box.
        p: Flip probability, [0, 1].
        flip: What a false report is: a word, or a flip of every report, whose rate does not count.
        modality: As for :func:`lockprobe.propagate`: ``symbolic?tell=state``, or ``symbolic``, with outcomes too.
        trials: Number of trials.
        seed: Seed of the study.
        repetition: Repetition of the study, from 1.
        max_steps: Budget in steps.
        shuffle: How often the order of the list is drawn: in every ``trial``, once for the ``study``, ``never``.
    """
    check_choice("shuffle", shuffle, get_args(Shuffle))
    check_whole("trials", trials, 1)
    check_whole("repetition", repetition, 1)
    check_whole("seed", seed, 0)
    policy, tell = policy_of(agent), what_is_told(modality, "memoryless" if isinstance(flip, OutcomeFlip) else flip)
    like = flip if isinstance(flip, OutcomeFlip) else flip_of(flip)
    world = world_of(box, flip=like.at_rate(p), max_steps=max_steps, tell=tell)
    if trials * max_steps > MOST_STEPS:
        raise BadValue("steps of all trials", trials * max_steps, f"at most {MOST_STEPS}")
    rows = (np.arange(first, min(first + PIECE, trials + 1)) for first in range(1, trials + 1, PIECE))
    parts = [_played(policy, world, shuffle, seed, repetition, one) for one in rows]
    name = agent if isinstance(agent, str) else type(policy).__name__
    solved, steps, actions, moved, told_moved = map(np.concatenate, zip(*parts, strict=True))
    return Population(solved, steps, actions, moved, told_moved, name, world)


def _played(
    policy: Policy[Any], world: World, shuffle: Shuffle, seed: int, repetition: int, trials: Whole
) -> tuple[NDArray[Any], ...]:
    """The columns of the trials with these numbers."""
    flip, space, budget, box = world.flip, world.space, world.budget, world.box
    shape, rows = (len(trials), budget), np.arange(len(trials))
    solved, ends = np.zeros(len(trials), bool), np.full(len(trials), budget, np.int32)
    actions, moves, told_moves = np.full(shape, -1, np.int8), np.zeros(shape, bool), np.zeros(shape, bool)
    orders = _orders(box, shuffle, seed, repetition, trials)
    boxes, minds = Boxes(space.may_move, space.start, [flip], orders.copy()), Minds(policy, world)
    start, mind = boxes.told.copy(), minds.begin(orders)
    for step in range(1, budget + 1):
        luck = partial(numbers, box.name, seed=seed, repetition=repetition, trial=trials[rows], step=step)
        places = minds.choose(mind, luck("agent")[:, 0])
        count = flip.numbers(space.joints)
        drawn = luck(f"{flip.stream}-0", places=count).T if flip.p else np.ones((count, 1))
        last = boxes.told[rows]
        joints, moved, outcome = boxes.attempt(rows, places, [drawn])
        told = boxes.told[rows]
        said = ((told ^ last) >> places & 1).astype(bool) if world.states_only else outcome
        at = (rows, step - 1)
        actions[at], moves[at], told_moves[at] = joints, moved, said
        done = moved & (joints == space.target)
        solved[rows[done]], ends[rows[done]] = True, step
        on = ~done
        rows = rows[on]
        if not rows.size:
            break
        mind = minds.remember(mind[on], places[on], said[on], told[on] ^ start[rows])
    return solved, ends, actions, moves, told_moves


def _orders(box: Lockbox, shuffle: Shuffle, seed: int, repetition: int, trials: Whole) -> Whole:
    """The joints as these trials list them, by index in panel order, shape (trials, joints)."""
    joints = len(box.joints)
    if shuffle == "trial":
        return drawn_orders(
            numbers(box.name, "labels", seed=seed, repetition=repetition, trial=trials, places=2 * joints)
        )[1]
    order = orders_of_study(box, seed)[1] if shuffle == "study" else range(joints)
    return np.tile(np.array(order), (len(trials), 1))
