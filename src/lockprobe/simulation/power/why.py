"""Power of a study of controls: how often its verdict is right, and how often wrong, if an effect is as stated.

Arms share no luck here. A seeded agent shares its luck between arms, and needs fewer blocks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.blocks import Blocks
from lockprobe.statistics.why.arms import ARMS
from lockprobe.statistics.why.mechanism import MARGIN, Claim, Verdict, decide

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


def why_power(
    name: str, success: Sequence[float], *, blocks: Sequence[int] = BLOCKS, studies: int = 200, seed: int = 1
) -> list[VerdictRates]:
    """The verdict rates of studies of a stated effect.

    Args:
        name: Name of the effect.
        success: Success in each of :data:`~lockprobe.statistics.why.arms.ARMS`, each in [0, 1].
        blocks: Study sizes in blocks, each at least 2.
        studies: Simulated studies of each size.
        seed: Seed of everything.

    Raises:
        BadValue: If these are not as many shares as arms, or a number is too small.
    """
    if len(success) != len(ARMS) or not all(0 <= share <= 1 for share in success):
        raise BadValue("success", list(success), f"{len(ARMS)} shares from 0 to 1, for {', '.join(ARMS)}")
    for what, number, least in (("blocks", min(blocks), 2), ("studies", studies, 1)):
        if number < least:
            raise BadValue(what, number, f"a number from {least}")
    truth, total, rates = due(success), success[1] - success[0], []
    for size in blocks:
        rng = generator(seed, "stated", name, str(size))
        drawn = (rng.random((size, len(ARMS))) < np.array(success) for _ in range(studies))
        found = [decide(Blocks(solved=dict(zip(ARMS, one.T.astype(np.float64), strict=True)))) for one in drawn]
        verdicts = Counter(one.verdict for one in found)
        rates.append(
            VerdictRates(
                effect=name,
                truth=truth,
                change=total,
                blocks=size,
                studies=studies,
                verdicts=dict(verdicts.most_common()),
                claims=dict(Counter(claim for one in found for claim in one.claims).most_common()),
                right=sum(n for verdict, n in verdicts.items() if right(verdict, truth, total)) / studies,
                wrong=sum(n for verdict, n in verdicts.items() if wrong(verdict, truth, total)) / studies,
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
