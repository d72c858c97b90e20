"""Populations: many simulated trials of one agent under one condition, without records.

Precise curves need thousands of trials per point. Trial i equals that of :func:`lockprobe.run_trial`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
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
from lockprobe.simulation.kernel import Played, Whole, World, play, policy_of, what_is_told, world_of
from lockprobe.statistics.loops import onset
from lockprobe.trial.luck import numbers
from lockprobe.trial.plan import drawn_orders, orders_of_study

MOST_STEPS = 1_000_000_000
"""Three bytes each are kept."""

PIECE = 8_192
"""Trials played at once: their numbers fit into the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Population(Played):
    """The outcomes of many trials of one agent under one condition; columns have one row per trial.

    ``agent`` is its spec, or the name of its class; ``world`` has the box, its reports and the budget.
    """

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

    def loops(self, *, overlap: bool = False, min_length: int = 3) -> NDArray[np.bool_]:
        """Whether each trial holds an action loop; settings as in :func:`lockprobe.statistics.loops.cover`."""
        played = (row[:steps].tolist() for row, steps in zip(self.actions, self.steps, strict=True))
        return np.array([onset(actions, overlap=overlap, min_length=min_length) > 0 for actions in played])


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
    parts = []
    for first in range(1, trials + 1, PIECE):
        rows = np.arange(first, min(first + PIECE, trials + 1))
        orders = _orders(world.box, shuffle, seed, repetition, rows)
        parts.append(play(policy, world, orders, seed=seed, repetition=repetition, first=first))
    return Population(
        **{one.name: np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(Played)},
        agent=agent if isinstance(agent, str) else type(policy).__name__,
        world=world,
    )


def _orders(box: Lockbox, shuffle: Shuffle, seed: int, repetition: int, trials: Whole) -> Whole:
    """The joints as these trials list them, by index in panel order, shape (trials, joints)."""
    joints = len(box.joints)
    if shuffle == "trial":
        return drawn_orders(
            numbers(box.name, "labels", seed=seed, repetition=repetition, trial=trials, places=2 * joints)
        )[1]
    order = orders_of_study(box, seed)[1] if shuffle == "study" else range(joints)
    return np.tile(np.array(order), (len(trials), 1))
