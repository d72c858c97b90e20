"""Simulated agents whose truth is known, as trials that any analysis can read.

A *world* says what is true: how often the box is solved at each p, how readily the agent falls into a cycle, and
whether a loop, once complete, makes solving less likely. Nothing else differs between conditions. An agent acts
without immediate repeats; the box opens by a clock of its own, from the fourth step on with an equal chance at every
step, so that solved trials are shorter whether or not loops matter. The joint that opens it counts as the target.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.inference.verdict import Question
from lockprobe.analysis.loops import onset_batch
from lockprobe.analysis.outcomes import Outcomes
from lockprobe.errors import BadValue, UnknownName
from lockprobe.record import Decision, Step, Trial

__all__ = ["BUDGET", "WORLDS", "Design", "P", "World", "simulate", "simulate_outcomes", "world"]

BUDGET = 20
P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
JOINTS = ("A", "B", "C", "D")
FIRST = 4
"""The earliest step at which the box opens: the optimum of chain-4."""

ESCAPE = 0.1
"""Chance per step to leave a cycle."""

PERIODS = (3, 4)

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """What is true of a simulated agent. ``success`` and ``trap`` are given at each p of the design, ascending.

    Attributes:
        name: Its name.
        says: The truth in one sentence.
        success: Probability to solve the box within the budget as long as loops do no harm, [0, 1).
        trap: Chance per step to fall into a cycle of three or four actions, [0, 1]; 0 acts at random throughout.
        harm: Factor on the chance to solve once a loop is complete; 1 if loops are irrelevant, below 1 if they hurt.
        shared: Share of trials that have the same luck at every p, [0, 1].
        truths: Questions whose true answer is yes: ``success``, ``speed``, ``shape``, ``looping``, ``harm``.
    """

    name: str
    says: str
    success: tuple[float, ...]
    trap: tuple[float, ...]
    harm: float
    shared: float
    truths: frozenset[Question]


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """How much is played; the paper's flip study by default (Sec. 3.2).

    Attributes:
        p: Flip probabilities, ascending.
        repetitions: Times the whole is repeated.
        trials: Trials per repetition and p.
    """

    p: tuple[float, ...] = P
    repetitions: int = 3
    trials: int = 10

    @property
    def clusters(self) -> int:
        """Trials per p."""
        return self.repetitions * self.trials


_FREE = (0.0,) * 7

WORLDS: Mapping[str, World] = {
    made.name: made
    for made in (
        World(
            name="no-effect",
            says="Nothing depends on p, and loops are irrelevant.",
            success=(0.5,) * 7,
            trap=_FREE,
            harm=1.0,
            shared=0.0,
            truths=frozenset(),
        ),
        World(
            name="shared-luck",
            says="Nothing depends on p, loops are irrelevant, and half of the trials go alike at every p.",
            success=(0.5,) * 7,
            trap=_FREE,
            harm=1.0,
            shared=0.5,
            truths=frozenset(),
        ),
        World(
            name="loops-irrelevant",
            says="Success rises and falls, so that trials differ in length; actions are random and loops irrelevant.",
            success=(0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5),
            trap=_FREE,
            harm=1.0,
            shared=0.0,
            truths=frozenset({"success", "speed", "shape"}),
        ),
        World(
            name="loop-trapped",
            says="Told the truth the agent falls into cycles, and a loop keeps it from solving; false reports free it.",
            success=(0.85,) * 7,
            trap=(0.5, 0.25, 0.12, 0.06, 0.03, 0.03, 0.03),
            harm=0.1,
            shared=0.0,
            truths=frozenset({"success", "speed", "looping", "harm"}),
        ),
        World(
            name="saturating",
            says="Success rises and stays; loops are irrelevant.",
            success=(0.23, 0.45, 0.57, 0.63, 0.66, 0.67, 0.67),
            trap=_FREE,
            harm=1.0,
            shared=0.0,
            truths=frozenset({"success", "speed"}),
        ),
        World(
            name="inverted-u",
            says="Success rises to 0.9 and falls to 0.2; loops are irrelevant.",
            success=(0.2, 0.55, 0.8, 0.9, 0.8, 0.55, 0.2),
            trap=_FREE,
            harm=1.0,
            shared=0.0,
            truths=frozenset({"success", "speed", "shape"}),
        ),
    )
}


def world(name: str) -> World:
    """A world by name.

    Raises:
        UnknownName: If there is none; the message lists those that exist.
    """
    if name not in WORLDS:
        raise UnknownName("world", name, tuple(WORLDS))
    return WORLDS[name]


def simulate(truth: World, design: Design, rng: np.random.Generator) -> list[Trial]:
    """One study of a simulated agent.

    Args:
        truth: The world.
        design: Which p, and how many trials.
        rng: The stream of this study.

    Returns:
        Trials by p, repetition and trial.
    """
    actions, ends = _play(truth, design, rng)
    return [
        _trial(truth.name, design, place, actions[place, : end or BUDGET].tolist(), solved=end > 0)
        for place, end in enumerate(ends.tolist())
    ]


def simulate_outcomes(truth: World, design: Design, rng: np.random.Generator) -> Outcomes:
    """The same study as columns: ``outcomes(simulate(...))``, without the records between."""
    actions, ends = _play(truth, design, rng)
    length, onset = np.where(ends > 0, ends, BUDGET), onset_batch(actions)
    cluster = np.tile(np.arange(design.clusters), len(design.p))
    return Outcomes(
        p=np.repeat(np.array(design.p, dtype=np.float64), design.clusters),
        repetition=cluster // design.trials + 1,
        trial=cluster % design.trials + 1,
        length=length,
        solved=ends > 0,
        onset=np.where(onset <= length, onset, 0),
    )


def _play(truth: World, design: Design, rng: np.random.Generator) -> tuple[Integers, Integers]:
    """Actions as if no trial ended early, shape (trials, BUDGET), and the step that solves each, 0 if none does."""
    if len(truth.success) != len(design.p) or len(truth.trap) != len(design.p):
        raise BadValue(f"world {truth.name}", f"{len(truth.success)} shares", f"one for each of {len(design.p)} p")
    conditions = np.repeat(np.arange(len(design.p)), design.clusters)
    luck = _luck(truth.shared, len(design.p), design.clusters, rng)
    actions = _actions(np.array(truth.trap)[conditions], luck)
    return actions, _solved_at(np.array(truth.success)[conditions], truth.harm, onset_batch(actions), luck[:, :, 2])


def _luck(shared: float, conditions: int, clusters: int, rng: np.random.Generator) -> Floats:
    """Uniform numbers of shape (conditions x clusters, BUDGET, 3): for choosing, for cycling, for solving."""
    own = rng.random((conditions, clusters, BUDGET, 3))
    common = rng.random((clusters, BUDGET, 3))
    alike = rng.random(clusters) < shared
    return np.where(alike[:, None, None], common, own).reshape(-1, BUDGET, 3)


def _actions(trap: Floats, luck: Floats) -> Integers:
    """What the agent attempts, whether or not the box has opened, shape (trials, BUDGET)."""
    n = len(trap)
    actions = np.empty((n, BUDGET), dtype=np.int64)
    actions[:, 0] = luck[:, 0, 0] * len(JOINTS)
    period = np.zeros(n, dtype=np.int64)
    everyone = np.arange(n)
    for t in range(1, BUDGET):
        other = (luck[:, t, 0] * (len(JOINTS) - 1)).astype(np.int64)
        fresh = other + (other >= actions[:, t - 1])
        # One number decides both ways: whether a cycle begins (and its period), or whether it ends.
        chance = luck[:, t, 1]
        begun = np.where(chance < trap / 2, PERIODS[0], PERIODS[1])
        period = np.where(period > 0, np.where(chance < ESCAPE, 0, period), np.where(chance < trap, begun, 0))
        period = np.where(period > t, 0, period)
        actions[:, t] = np.where(period > 0, actions[everyone, np.maximum(t - period, 0)], fresh)
    return actions


def _solved_at(success: Floats, harm: float, onset: Integers, luck: Floats) -> Integers:
    """The step at which each trial is solved, 0 if it is not. A loop that is complete at t tells from t + 1 on."""
    steps = np.arange(1, BUDGET + 1)
    hazard = (1 - (1 - success) ** (1 / (BUDGET - FIRST + 1)))[:, None] * (steps >= FIRST)
    looped = (onset[:, None] > 0) & (onset[:, None] < steps)
    opened = luck < np.where(looped, harm, 1.0) * hazard
    return np.where(opened.any(axis=1), opened.argmax(axis=1) + 1, 0)


_DECISIONS = tuple(Decision(joint=joint) for joint in JOINTS)


def _trial(name: str, design: Design, place: int, actions: list[int], *, solved: bool) -> Trial:
    """One record. The box opens at the joint attempted last, which therefore is the target."""
    condition, cluster = divmod(place, design.clusters)
    repetition, trial = (number + 1 for number in divmod(cluster, design.trials))
    last = len(actions) - 1
    p = design.p[condition]
    return Trial(
        key=f"audit/{name}/p={p:g}/rep={repetition}/trial={trial}",
        study="audit",
        agent=f"simulated:{name}",
        facts={},
        box="clock",
        modality="symbolic",
        p=p,
        flip="transient",
        channels=(),
        repetition=repetition,
        trial=trial,
        seed=0,
        budget=BUDGET,
        joints=JOINTS,
        labels=JOINTS,
        listing=JOINTS,
        target=JOINTS[actions[-1]],
        opening="",
        steps=tuple(
            Step(
                step=i + 1,
                state="0000",
                joint=JOINTS[action],
                moved=solved and i == last,
                told_moved=solved and i == last,
                told_state=None,
                told="",
                decision=_DECISIONS[action],
            )
            for i, action in enumerate(actions)
        ),
        ending="solved" if solved else "budget",
    )
