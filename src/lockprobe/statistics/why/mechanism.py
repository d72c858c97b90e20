"""Which reports do what false reports do: the rule of the study of controls.

Six arms decide: true reports, false reports, and four arms of one form, in which a report has two statements. They are
written here by the first and the last statement: TT, FT (a lie that the truth corrects), TF (a truth that a lie
corrects) and FF. With an irrelevant remark after true reports (R) there are seven. All hit the same steps of the same
trials.

The total effect F - T is tested first, at 5 %. Only if it is detected, contrasts of arms are computed, and a claim
needs *all* of its contrasts (intersection-union), each with P below 0.03 and an interval that excludes 0. So a claim
that is false of the arms is made in at most 5 % of studies, although several claims are tried.

The paper compares success curves and loop rates only (Sec. 3.2 and 3.3), which cannot tell these claims apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.statistics.agent_comparison.paired import Array, numbers_of
from lockprobe.statistics.blocks import Blocks, Weights, contrast
from lockprobe.statistics.boxes import small_over_boxes
from lockprobe.statistics.paired_proportions import equivalence
from lockprobe.statistics.proportions import ALPHA, Difference
from lockprobe.statistics.sequential.contrasts import at_every_look

MARGIN = 0.1
"""Equivalence margin: changes of success up to 10 percentage points count as none. The value is a convention."""

PART = 0.03
"""Level of the test of each contrast of arms; chosen by simulation, so that a claim on arms that is false is made in at
most 5 % of studies."""

Claim = Literal["last", "first", "agreed", "contradiction", "falsity", "form"]
"""What reports change success as false reports do: those whose last statement is false; whose first is; whose two
statements both are, and no others; with a single false statement already; with two false statements, and which of them
counts is not decided; any odd report, true corrections and remarks too."""

CONTENT: tuple[Claim, ...] = ("last", "first", "agreed", "contradiction", "falsity")
"""The claims that false reports act through what they say."""

Verdict = Literal["says", "form", "both", "blurred", "not decided", "no change", "inconclusive"]
"""False reports act through what they say; as any odd report does; in both ways; they change success, and a true
correction does it as well, so that corrections cannot show why; they change it, and how is not decided; they change it
by less than the margin; no change is detected, and one of the margin is not excluded."""

Pairs = tuple[tuple[str, str], ...]
"""Pairs of arms, whose differences are averaged."""

CONTRASTS: Mapping[str, Pairs] = {
    "false last after true": (("truth-lie", "truth-truth"),),
    "false last after false": (("lie-lie", "lie-truth"),),
    "false first before true": (("lie-truth", "truth-truth"),),
    "false first before false": (("lie-lie", "truth-lie"),),
    "both false": (("lie-lie", "truth-truth"),),
    "interaction": (("lie-truth", "truth-truth"), ("truth-lie", "lie-lie")),
    "true correction": (("truth-truth", "truth"),),
    "remark": (("remark", "truth"),),
}
"""Contrast -> pairs of arms, whose mean difference it is. The interaction is half of FT + TF - TT - FF."""

TOTAL = (("lie", "truth"),)
"""The pair of arms of the total effect."""

NEEDS: Mapping[Claim, tuple[str, ...]] = {
    "last": ("false last after true", "false last after false"),
    "first": ("false first before true", "false first before false"),
    "agreed": ("both false", "false last after false", "false first before false", "-interaction"),
    "contradiction": ("false first before true", "false last after true", "interaction"),
    "form": ("true correction", "remark"),
    "falsity": ("both false",),
}
"""Claim -> the contrasts that must all go in the direction of the total effect."""

_OTHERS = ("true correction", "false first before true", "false last after true")
"""The contrasts that show other reports to do it than those whose two statements are both false."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What a study of controls decides on one agent.

    Attributes:
        total: Success under false reports minus success under true reports.
        contrasts: Contrast of arms -> its mean over blocks; none unless the total effect is detected.
        claims: The claims that hold; none unless the total effect is detected.
        equivalence: P value of two one-sided tests of a total effect of the margin or more, [0, 1].
        verdict: The conclusion.
    """

    total: Difference
    contrasts: Mapping[str, Difference]
    claims: tuple[Claim, ...]
    equivalence: float
    verdict: Verdict

    @property
    def way(self) -> int:
        """The direction of the total effect, 1 or -1."""
        return 1 if self.total.value > 0 else -1


def decide(blocks: Blocks, *, agents: int = 1) -> Decision:
    """The decision from the blocks of the arms, of so many agents that are judged together (Bonferroni).

    The arms are those of :data:`~lockprobe.statistics.why.arms.PLANNED`, and ``remark`` for a claim on the form.
    """
    lie = weights_of(TOTAL)
    total = contrast(blocks, *lie, choices=agents)
    small = max(_equivalence(sums[:, 0], blocks, agents) for sums in blocks.sums(*lie))
    found = {}
    for name, pairs in CONTRASTS.items() if _detected(total) else ():
        if {arm for pair in pairs for arm in pair} <= blocks.solved.keys():
            found[name] = contrast(blocks, *weights_of(pairs), choices=agents)
    return decision_of(total, found, small)


def weights_of(pairs: Pairs) -> list[Weights]:
    """The first arm of each pair less the second."""
    return [{more: 1, less: -1} for more, less in pairs]


def decision_of(total: Difference, contrasts: Mapping[str, Difference], small: float) -> Decision:
    """The decision from means over blocks, as in :class:`Decision`; contrasts count only if the total is detected."""
    if not _detected(total):
        none: Verdict = "no change" if small < ALPHA else "inconclusive"
        return Decision(total=total, contrasts={}, claims=(), equivalence=small, verdict=none)
    way = 1 if total.value > 0 else -1
    claims = _claims(contrasts, way)
    says, form = any(claim in CONTENT for claim in claims), "form" in claims
    verdict: Verdict = "blurred" if _goes(contrasts, "true correction", way) else "not decided"
    if says or form:
        verdict = "both" if says and form else "says" if says else "form"
    return Decision(total=total, contrasts=contrasts, claims=claims, equivalence=small, verdict=verdict)


def _claims(contrasts: Mapping[str, Difference], way: int) -> tuple[Claim, ...]:
    """The claims of which all contrasts go this way."""
    held = [claim for claim, needs in NEEDS.items() if all(_goes(contrasts, name, way) for name in needs)]
    if "contradiction" in held and _one_exceeds_both(contrasts, way):
        held.remove("contradiction")
    if "agreed" in held and any(_goes(contrasts, name, way) for name in _OTHERS):
        held.remove("agreed")
    if any(claim in held for claim in CONTENT[:-1]):
        held = [claim for claim in held if claim != "falsity"]
    return tuple(held)


def _goes(contrasts: Mapping[str, Difference], name: str, way: int) -> bool:
    """Whether a contrast is detected in this direction; a minus sign before it turns it round."""
    name, way = (name[1:], -way) if name.startswith("-") else (name, way)
    found = contrasts.get(name)
    return found is not None and _detected(found, PART) and found.value * way > 0


def _one_exceeds_both(contrasts: Mapping[str, Difference], way: int) -> bool:
    """Whether one false statement does more than two of them, by over a quarter of what two do.

    Then the statements' disagreement itself acts, which a plain false report has not.
    """
    both = way * contrasts["both false"].value
    one = way * (contrasts["false first before true"].value + contrasts["false last after true"].value) / 2
    return one - both > max(0.0, both) / 4


def _detected(found: Difference, level: float = ALPHA) -> bool:
    return found.p_value is not None and found.p_value < level and found.clear


def _equivalence(changes: Array, blocks: Blocks, agents: int) -> float:
    """P value of two one-sided tests that the change is at most -margin, or at least margin (Schuirmann 1987)."""
    if blocks.planned:
        return at_every_look([numbers_of(changes[:, None])], agents=agents, margin=MARGIN)[0].small_p_value
    known = ~np.isnan(changes)
    kept = changes[known]
    found = equivalence(int(np.sum(kept < 0)), int(np.sum(kept > 0)), len(kept), MARGIN)
    over = small_over_boxes(kept, blocks.box[known], MARGIN) if len(blocks.box) else 0.0
    return min(1.0, agents * max(found, over))
