"""Effects that a user states, as studies: over flip rates, of a study of controls, over boxes.

*Over flip rates* an agent acts without immediate repeats. From the fourth step on, the box opens with equal probability
at every step, whatever the joint: loops do nothing, and solved trials are shorter. Trials share no luck over flip
rates, like those of a sampled model. With shared luck, differences of success need fewer trials, and tests of speed and
loops other numbers.

*Of a study of controls* (``why``) it is counted how often its verdict is right, and how often wrong. Arms share no luck
here. A seeded agent shares its luck between arms, and needs fewer blocks.

*Over boxes* it is counted how often a study shows, of boxes like these, that a condition changes success.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Needed, Simulation, detections, needed
from lockprobe.statistics.blocks import Blocks
from lockprobe.statistics.inference.over_doses import TESTS, Question, p_values
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.paired_proportions import FEWEST, Pairs, difference_over_boxes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why.arms import ARMS
from lockprobe.statistics.why.mechanism import MARGIN, Claim, Verdict, decide

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
    found = zip(worlds, detections(worlds, sizes, how, seed), strict=True)
    return [(world, question, needed(of, question, how)) for world, of in found for question in world.asked]


BLOCKS = (50, 150, 300, 600)
"""Sizes of studies whose verdicts are counted."""

_ASSERTED: Mapping[Verdict, frozenset[Literal["changes", "no change", "says", "form"]]] = {
    "says": frozenset({"changes", "says"}),
    "form": frozenset({"changes", "form"}),
    "both": frozenset({"changes", "says", "form"}),
    "blurred": frozenset({"changes"}),
    "not decided": frozenset({"changes"}),
    "no change": frozenset({"no change"}),
    "inconclusive": frozenset(),
}
"""What a verdict asserts: that lies change success; that they change it by less than the margin; that they act
through what they say; that they act as any odd report does."""

STATED: Mapping[str, tuple[float, ...]] = {
    "what they say last": (0.23, 0.67, 0.23, 0.23, 0.67, 0.67, 0.23),
    "what they say first": (0.23, 0.67, 0.23, 0.67, 0.23, 0.67, 0.23),
    "as any odd report": (0.23, 0.67, 0.67, 0.67, 0.67, 0.67, 0.67),
    "small, said last": (0.45, 0.60, 0.45, 0.45, 0.60, 0.60, 0.45),
    "no change": (0.45,) * 7,
}
"""Effect -> success in each of :data:`~lockprobe.statistics.why.arms.ARMS`: three of the paper's size (Sec. 3.2), a
small one, and none."""

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class VerdictRates:
    """The verdicts of studies of one size.

    Attributes:
        effect: Name of the stated effect.
        truth: What a study concludes that is large enough.
        change: The change of success by lies, [-1, 1].
        blocks: Blocks per study.
        studies: Number of studies.
        verdicts: Verdict -> number of studies that concluded it, most frequent first.
        claims: Claim -> number of studies that made it, most frequent first.
        right: Share of studies whose verdict is :func:`right`, [0, 1].
        wrong: Share of studies whose verdict is :func:`wrong`, [0, 1].
    """

    effect: str
    truth: Verdict
    change: float
    blocks: int
    studies: int
    verdicts: Mapping[Verdict, int]
    claims: Mapping[Claim, int]
    right: float
    wrong: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Arms:
    """A study of controls, with its success in each of :data:`~lockprobe.statistics.why.arms.ARMS`."""

    name: str
    success: tuple[float, ...]

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", "why", self.name

    def detected(
        self, trials: int, luck: np.random.Generator, tests: np.random.Generator
    ) -> Iterator[tuple[str, Verdict | Claim]]:
        """The verdict and the claims of one study."""
        solved = luck.random((trials, len(ARMS))) < np.array(self.success)
        found = decide(Blocks(solved=dict(zip(ARMS, solved.T.astype(np.float64), strict=True))))
        yield "verdict", found.verdict
        yield from (("claim", claim) for claim in found.claims)


def why_power(effects: Mapping[str, Sequence[float]], how: Simulation, *, seed: int = 1) -> list[VerdictRates]:
    """The verdict rates of studies of stated effects.

    Args:
        effects: Name -> success in each of :data:`~lockprobe.statistics.why.arms.ARMS`, each in [0, 1].
        how: How much is simulated; trials per condition are blocks.
        seed: Seed of everything.

    Raises:
        BadValue: If these are not as many shares as arms.
    """
    for success in effects.values():
        if len(success) != len(ARMS) or not all(0 <= share <= 1 for share in success):
            raise BadValue("success", list(success), f"{len(ARMS)} shares from 0 to 1, for {', '.join(ARMS)}")
    arms = [Arms(name=name, success=tuple(success)) for name, success in effects.items()]
    rates = []
    for one, found in zip(arms, detections(arms, how.trials, how, seed), strict=True):
        truth, total = due(one.success), one.success[1] - one.success[0]
        for size, of in found.items():
            verdicts = {verdict: n for verdict in get_args(Verdict) if (n := of["verdict", verdict])}
            claims = {claim: n for claim in get_args(Claim) if (n := of["claim", claim])}
            rates.append(
                VerdictRates(
                    effect=one.name,
                    truth=truth,
                    change=total,
                    blocks=size,
                    studies=how.studies,
                    verdicts=dict(Counter(verdicts).most_common()),
                    claims=dict(Counter(claims).most_common()),
                    right=sum(n for verdict, n in verdicts.items() if right(verdict, truth, total)) / how.studies,
                    wrong=sum(n for verdict, n in verdicts.items() if wrong(verdict, truth, total)) / how.studies,
                )
            )
    return rates


def right(verdict: Verdict, truth: Verdict, total: float) -> bool:
    """Whether it is the verdict that is due, or that the change is below the margin, if it is."""
    return verdict == truth or (verdict == "no change" and abs(total) < MARGIN)


def wrong(verdict: Verdict, truth: Verdict, total: float) -> bool:
    """Whether a verdict asserts something false.

    That is a way of acting that is not the effect's, any way or change where nothing changes, or ``no change`` where
    the change is the margin or more.
    """
    small = {"no change"} if abs(total) < MARGIN else set()
    return not _ASSERTED[verdict] <= (_ASSERTED[truth] - {"no change"} | small)


def due(success: Sequence[float]) -> Verdict:
    """What a study concludes that is large enough, by success in each of :data:`~lockprobe.statistics.why.arms.ARMS`.

    What reports say acts if two false statements do more than two true ones in the direction of the total effect, or if
    a false statement does wherever it stands last, or first; the form acts if true corrections and remarks do it too.
    """
    truth, lie, both_true, lie_truth, truth_lie, both_false, remark = success
    if lie == truth:
        return "no change"

    def more(one: float, other: float) -> bool:
        return (one - other) * (lie - truth) > _ROUNDING

    says = (
        more(both_false, both_true)
        or (more(truth_lie, both_true) and more(both_false, lie_truth))
        or (more(lie_truth, both_true) and more(both_false, truth_lie))
    )
    corrections = more(both_true, truth)
    form = corrections and more(remark, truth)
    if says:
        return "both" if form else "says"
    if form:
        return "form"
    return "blurred" if corrections else "not decided"


DIFFICULTY_SD, EFFECT_SD = 0.15, 0.15
"""Standard deviation of success, and of its change, between boxes; chosen by eye."""

MOST_BOXES = 1_000

OVER_BOXES = Simulation(trials=(1, 2, 3, 5, 10, 20), least=1, studies=1000)
"""How much is simulated of studies over boxes: trials on each box under each condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Boxes:
    """Success on several boxes under a control and under a condition.

    Attributes:
        success: The mean success over boxes under the control and under the condition.
        boxes: Number of boxes.
        effect_sd: Standard deviation of the change between boxes.
    """

    success: tuple[float, ...]
    boxes: int
    effect_sd: float = EFFECT_SD

    def __post_init__(self) -> None:
        if len(self.success) != 2 or not all(0 <= share <= 1 for share in self.success):
            expected = "two shares: under the control, and under the condition"
            raise BadValue("success", ",".join(map(str, self.success)), expected)
        if not FEWEST <= self.boxes <= MOST_BOXES:
            expected = f"at least {FEWEST}, for a sentence on boxes like these, and at most {MOST_BOXES}"
            raise BadValue("boxes", self.boxes, expected)
        if not 0 <= self.effect_sd <= 1:
            raise BadValue("effect-sd", self.effect_sd, "a standard deviation of shares, 0 to 1")

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", "boxes", str(self.boxes)

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> Iterator[str]:
        """``change`` if one study shows it; trials share no luck."""
        base = self.success[0] + DIFFICULTY_SD * luck.standard_normal(self.boxes)
        change = self.success[1] - self.success[0] + self.effect_sd * luck.standard_normal(self.boxes)
        before, after = luck.random((2, trials, self.boxes)) < np.clip([[base], [base + change]], 0, 1)
        lost, gained = ((one & ~other).sum(axis=0) * 1.0 for one, other in ((before, after), (after, before)))
        pairs = Pairs(first=lost, second=gained, n=np.full(self.boxes, float(trials)))
        if difference_over_boxes(pairs).interval_p < ALPHA:
            yield "change"


def power_over_boxes(effects: Sequence[Boxes], how: Simulation, *, seed: int = 1) -> dict[tuple[int, int], float]:
    """How often a study detects the change of success, by the test of the report.

    Returns:
        Number of boxes and of trials on each -> the share of studies that detect it.
    """
    found = detections(effects, how.trials, how, seed)
    return {
        (one.boxes, size): of[size]["change"] / how.studies
        for size in how.trials
        for one, of in zip(effects, found, strict=True)
    }
