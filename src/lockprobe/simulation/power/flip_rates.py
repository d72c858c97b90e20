"""Power of every test over flip rates at a stated effect: the outcomes of an agent of known truth, as columns.

The agent acts without immediate repeats. From the fourth step on, the box opens with equal probability at every step,
whatever the joint: loops do nothing, and solved trials are shorter. Trials share no luck over flip rates, like those of
a sampled model. With shared luck, differences of success need fewer trials, and tests of speed and loops other numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Needed, Simulation, power
from lockprobe.statistics.inference.over_doses import TESTS, Question, p_values
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA

P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)

BUDGET = 20
JOINTS = 4
FIRST = 4
"""The earliest step at which the box opens: the optimum of chain-4."""

ESCAPE = 0.1
"""Chance per step to leave a cycle."""

PERIODS = (3, 4)

REPETITIONS = 3

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """The truth about a simulated agent; nothing else differs between flip rates.

    Attributes:
        name: Its name.
        says: The truth in one sentence.
        p: Flip probabilities, ascending; ``success`` and ``trap`` have one value for each.
        success: Probability of solving the box within the budget, [0, 1].
        trap: Probability per step of falling into a cycle of three or four actions, [0, 1]; 0 acts at random
            throughout.
        truths: Questions whose true answer is yes.
    """

    name: str
    says: str
    p: tuple[float, ...] = P
    success: tuple[float, ...]
    trap: tuple[float, ...] = (0.0,) * len(P)
    truths: frozenset[Question]

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "audit", self.name

    @property
    def asked(self) -> list[Question]:
        """The questions that a test can answer with yes."""
        return [question for question in TESTS if question in self.truths]

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> list[Question]:
        """The questions that the tests answer with yes in a study of three repetitions.

        A test that cannot be computed does not.
        """
        found = p_values(self._outcomes(trials, luck), tests, BUDGET)
        return [question for question, p in found.items() if p is not None and p < ALPHA]

    def _outcomes(self, trials: int, rng: np.random.Generator) -> Outcomes:
        """One study, one row per trial, by p, repetition and trial."""
        luck = rng.random((len(self.p) * trials, BUDGET, 3))
        onset = onset_batch(actions_of(np.repeat(self.trap, trials), luck))
        solved = solved_at(np.repeat(self.success, trials), luck[:, :, 2])
        length = np.where(solved > 0, solved, BUDGET)
        number, each = np.tile(np.arange(trials), len(self.p)), trials // REPETITIONS
        return Outcomes(
            dose=np.repeat(np.array(self.p, dtype=np.float64), trials),
            repetition=number // each + 1,
            trial=number % each + 1,
            length=length,
            solved=solved > 0,
            onset=np.where(onset <= length, onset, 0),
        )


def actions_of(trap: Floats, luck: Floats) -> Integers:
    """The joints attempted, even after the box has opened, shape (trials, BUDGET).

    Args:
        trap: Probability per step of falling into a cycle, shape (trials,).
        luck: Uniform random numbers for choices, cycles and solutions, shape (trials, BUDGET, 3).
    """
    n = len(trap)
    actions = np.empty((n, BUDGET), dtype=np.int64)
    actions[:, 0] = luck[:, 0, 0] * JOINTS
    period = np.zeros(n, dtype=np.int64)
    everyone = np.arange(n)
    for t in range(1, BUDGET):
        other = (luck[:, t, 0] * (JOINTS - 1)).astype(np.int64)
        fresh = other + (other >= actions[:, t - 1])
        # One number decides both ways: whether a cycle begins (and its period), or whether it ends.
        chance = luck[:, t, 1]
        begun = np.where(chance < trap / 2, PERIODS[0], PERIODS[1])
        period = np.where(period > 0, np.where(chance < ESCAPE, 0, period), np.where(chance < trap, begun, 0))
        period = np.where(period > t, 0, period)
        actions[:, t] = np.where(period > 0, actions[everyone, np.maximum(t - period, 0)], fresh)
    return actions


def solved_at(success: Floats, luck: Floats) -> Integers:
    """The step at which each trial is solved, 0 if it is not."""
    steps = np.arange(1, BUDGET + 1)
    hazard = (1 - (1 - success) ** (1 / (BUDGET - FIRST + 1)))[:, None] * (steps >= FIRST)
    opened = luck < hazard
    return np.where(opened.any(axis=1), opened.argmax(axis=1) + 1, 0)


def default_worlds() -> tuple[World, ...]:
    """The default effects: a rise and fall of success like the paper's (Fig. 4), and a trap of loops (Sec. 3.3).

    The paper's text gives 0.23 at p = 0 and 2.85 times that at 0.4; the other values are assumptions.
    """
    return (
        World(
            name="loops-irrelevant",
            says="Success rises and falls, so that trials differ in length; actions are random and loops irrelevant.",
            success=(0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5),
            truths=frozenset({"success", "speed", "shape"}),
        ),
        World(
            name="loop-trapped",
            says="Told the truth the agent falls into cycles; false reports free it.",
            success=(0.85,) * 7,
            trap=(0.5, 0.25, 0.12, 0.06, 0.03, 0.03, 0.03),
            truths=frozenset({"looping"}),
        ),
    )


def stated_world(success: Sequence[float], *, p: Sequence[float] = P, trap: Sequence[float] = ()) -> World:
    """The simulated agent with the effect that a user states.

    Args:
        success: Probability of solving the box at each p, [0, 1).
        p: Flip probabilities, ascending, 0.000001 or more apart: nearly equal ones allow no trend.
        trap: Probability per step of falling into a cycle at each p, [0, 1]; 0 by default.
    """
    for name, values, what in (("success", success, "share"), ("trap", trap or p, "chance")):
        if len(values) != len(p):
            raise BadValue(name, _written(values), f"one {what} for each of {len(p)} flip rates")
    if list(p) != sorted(set(p)) or len(p) < 2 or not all(0 <= value <= 1 for value in p):
        raise BadValue("p", _written(p), "two values or more from 0 to 1, ascending")
    if any(round(high - low, 9) < 1e-6 for low, high in pairwise(p)):
        raise BadValue("p", ",".join(map(str, p)), "values that differ by 0.000001 or more")
    for value in success:
        if not 0 <= value < 1:
            raise BadValue("success", value, "a number from 0 below 1")
    for value in trap:
        if not 0 <= value <= 1:
            raise BadValue("trap", value, "a number from 0 to 1")
    chances, top = tuple(trap) or (0.0,) * len(p), max(success)
    answers: dict[Question, bool] = {
        "success": len(set(success)) > 1,
        "speed": len(set(success)) > 1,
        "shape": top > success[0] and top > success[-1],
        "looping": len(set(chances)) > 1,
        "looping again": min(chances) < min(chances[0], chances[-1]),
    }
    truths = frozenset(question for question, yes in answers.items() if yes)
    return World(name="stated", says="As stated.", p=tuple(p), success=tuple(success), trap=chances, truths=truths)


def _written(values: Sequence[float]) -> str:
    return ",".join(f"{value:g}" for value in values)


def flip_power(worlds: Sequence[World], how: Simulation, *, seed: int = 1) -> list[tuple[World, Question, Needed]]:
    """The power of every test whose true answer is yes, and the trials per p that it needs.

    Numbers of trials are rounded up to three whole repetitions.
    """
    sizes = [REPETITIONS * each for each in sorted({math.ceil(count / REPETITIONS) for count in how.trials})]
    found = zip(worlds, power(worlds, sizes, how, seed), strict=True)
    return [(world, question, needed[question]) for world, needed in found for question in world.asked]
