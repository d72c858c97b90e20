"""Effects that a user states, as studies: over flip rates, of a study of controls, over boxes.

Trials share no luck here, like those of a sampled model; with shared luck, differences need fewer trials.

*Over flip rates* it is counted how often a study detects that success depends on the rate, and that it rises and falls.

*Of a study of controls* (``why``) it is counted how often its verdict is right, and how often wrong.

*Over boxes* it is counted how often a study shows, of boxes like these, that a condition changes success.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Needed, Simulation, detections, needed, played
from lockprobe.statistics.arms import ARMS
from lockprobe.statistics.differences import any_difference
from lockprobe.statistics.pairs import FEWEST, paired
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.two_lines import rise_and_fall
from lockprobe.statistics.why import MARGIN, Claim, Verdict, decide

P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)

PAPER = (0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5)
"""Success at each flip rate, a rise and fall like the paper's (Fig. 4). Its text gives 0.23 at p = 0 and 2.85 times
that at 0.4; the other values are assumptions."""

Question = Literal["success", "shape"]

TESTS: Mapping[Question, str] = {
    "success": "greatest difference from the lowest dose, permutation",
    "shape": "two lines",
}
"""Question -> its test: whether the flip rate changes success, and whether success rises and falls again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlipRates:
    """Success at each of several flip rates, which are ascending."""

    success: tuple[float, ...] = PAPER
    p: tuple[float, ...] = P

    def __post_init__(self) -> None:
        said = ",".join(f"{value:g}" for value in self.p)
        if len(self.success) != len(self.p) or not all(0 <= share <= 1 for share in self.success):
            shares = ",".join(f"{value:g}" for value in self.success)
            raise BadValue("success", shares, f"one share from 0 to 1 for each of {len(self.p)} flip rates")
        if len(self.p) < 2 or not all(0 <= p <= 1 for p in self.p):
            raise BadValue("p", said, "two values or more from 0 to 1, ascending")
        if any(high - low < 1e-6 for low, high in pairwise(self.p)):
            raise BadValue("p", said, "ascending values that differ by 0.000001 or more")

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", "flip rates", *map(str, self.success)

    @property
    def asked(self) -> list[Question]:
        """The questions of which the true answer is yes."""
        top = max(self.success)
        yes = {"success": len({*self.success}) > 1, "shape": top > self.success[0] and top > self.success[-1]}
        return [question for question in TESTS if yes[question]]

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> Iterator[Question]:
        """The questions that the tests answer with yes in one study."""
        found = played(luck.random((trials, len(self.p))) < np.array(self.success), self.p)
        if any(one.p_value < ALPHA for one in any_difference(found, tests)):
            yield "success"
        if rise_and_fall(found).direction == "inverted U":
            yield "shape"


def flip_power(rates: FlipRates, how: Simulation, *, seed: int = 1) -> list[tuple[Question, Needed]]:
    """The power of every test whose true answer is yes, and the trials per flip rate that it needs."""
    (found,) = detections([rates], how, seed)
    return [(question, needed(found, question, how)) for question in rates.asked]


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
"""Effect -> success in each of :data:`~lockprobe.statistics.arms.ARMS`: three of the paper's size (Sec. 3.2), a small
one, and none."""

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
        right: Share of studies whose verdict is the one that is due, or says that the change is below the margin, if it
            is, [0, 1].
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
    """A study of controls, with its success in each of :data:`~lockprobe.statistics.arms.ARMS`."""

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
        found = decide({arm: played(solved[:, [i]], [0.0]) for i, arm in enumerate(ARMS)})
        yield "verdict", found.verdict
        yield from (("claim", claim) for claim in found.claims)


def why_power(effects: Mapping[str, Sequence[float]], how: Simulation, *, seed: int = 1) -> list[VerdictRates]:
    """The verdict rates of studies of stated effects.

    Args:
        effects: Name -> success in each of :data:`~lockprobe.statistics.arms.ARMS`, each in [0, 1].
        how: How much is simulated; trials per condition are blocks.
        seed: Seed of everything.

    Raises:
        BadValue: If these are not as many shares as arms.
    """
    for success in effects.values():
        if len(success) != len(ARMS) or not all(0 <= share <= 1 for share in success):
            raise BadValue("success", list(success), f"{len(ARMS)} shares from 0 to 1, for {', '.join(ARMS)}")
    arms, rates = [Arms(name=name, success=tuple(success)) for name, success in effects.items()], []
    for one, found in zip(arms, detections(arms, how, seed), strict=True):
        truth, total = due(one.success), one.success[1] - one.success[0]
        right = {truth, "no change"} if abs(total) < MARGIN else {truth}
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
                    right=sum(n for verdict, n in verdicts.items() if verdict in right) / how.studies,
                    wrong=sum(n for verdict, n in verdicts.items() if wrong(verdict, truth, total)) / how.studies,
                )
            )
    return rates


def wrong(verdict: Verdict, truth: Verdict, total: float) -> bool:
    """Whether a verdict asserts something false.

    That is a way of acting that is not the effect's, any way or change where nothing changes, or ``no change`` where
    the change is the margin or more.
    """
    small = {"no change"} if abs(total) < MARGIN else set()
    return not _ASSERTED[verdict] <= (_ASSERTED[truth] - {"no change"} | small)


def due(success: Sequence[float]) -> Verdict:
    """What a study concludes that is large enough, by success in each of :data:`~lockprobe.statistics.arms.ARMS`.

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
        """``change`` if one study shows it."""
        base = self.success[0] + DIFFICULTY_SD * luck.standard_normal(self.boxes)
        change = self.success[1] - self.success[0] + self.effect_sd * luck.standard_normal(self.boxes)
        before, after = luck.random((2, trials, self.boxes)) < np.clip([[base], [base + change]], 0, 1)
        box = np.tile(np.arange(self.boxes), trials)
        if paired(before.reshape(-1), after.reshape(-1), box).interval_p < ALPHA:
            yield "change"


def power_over_boxes(effects: Sequence[Boxes], how: Simulation, *, seed: int = 1) -> dict[tuple[int, int], float]:
    """How often a study detects the change of success, by the test of the report.

    Returns:
        Number of boxes and of trials on each -> the share of studies that detect it.
    """
    found = [*zip(effects, detections(effects, how, seed), strict=True)]
    return {(one.boxes, size): of[size]["change"] / how.studies for size in how.trials for one, of in found}
