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

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from statistics import NormalDist
from typing import Literal

import numpy as np

from lockprobe.statistics.arms import PLANNED, arms_of
from lockprobe.statistics.blocks import Weights, blocks_of, contrast, numbers_of
from lockprobe.statistics.broken_trials import ends_of
from lockprobe.statistics.contrast import Cells
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.design import Design
from lockprobe.statistics.every_look import at_every_look
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.pairs import equivalence, small_over_boxes
from lockprobe.statistics.proportions import ALPHA, Difference

MARGIN = 0.1
"""Equivalence margin: changes of success up to 10 percentage points count as none. The value is a convention."""

PART = 0.03
"""Level of the test of each contrast of arms; chosen by simulation, so that a claim on arms that is false is made in at
most 5 % of studies."""

_POWER = 0.8
"""The power for which the needed blocks are computed."""

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


def decide(groups: Mapping[str, Outcomes], *, agents: int = 1) -> Decision:
    """The decision from the trials of the arms, of so many agents that are judged together (Bonferroni).

    The arms are those of :data:`~lockprobe.statistics.arms.PLANNED`, and ``remark`` for a claim on the form.
    """
    total = contrast(groups, *weights_of(TOTAL), choices=agents)
    found = {}
    for name, pairs in CONTRASTS.items() if total.detected() else ():
        if {arm for pair in pairs for arm in pair} <= groups.keys():
            found[name] = contrast(groups, *weights_of(pairs), choices=agents)
    ends = ends_of([groups["lie"], groups["truth"]], [True, False])
    return decision_of(total, found, max(_equivalence(of, agents) for of in ends))


def weights_of(pairs: Pairs) -> list[Weights]:
    """The first arm of each pair less the second."""
    return [{more: 1, less: -1} for more, less in pairs]


def decision_of(total: Difference, contrasts: Mapping[str, Difference], small: float) -> Decision:
    """The decision from means over blocks, as in :class:`Decision`; contrasts count only if the total is detected."""
    if not total.detected():
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
    return found is not None and found.detected(PART) and found.value * way > 0


def _one_exceeds_both(contrasts: Mapping[str, Difference], way: int) -> bool:
    """Whether one false statement does more than two of them, by over a quarter of what two do.

    Then the statements' disagreement itself acts, which a plain false report has not.
    """
    both = way * contrasts["both false"].value
    one = way * (contrasts["false first before true"].value + contrasts["false last after true"].value) / 2
    return one - both > max(0.0, both) / 4


def _equivalence(groups: Sequence[Outcomes], agents: int) -> float:
    """P value of two one-sided tests that the change is at most -margin, or at least margin (Schuirmann 1987)."""
    blocks = blocks_of(groups)
    changes = blocks.solved[:, 0] - blocks.solved[:, 1]
    if blocks.order:
        of_all = [numbers_of(changes[:, None], blocks)]
        return at_every_look(of_all, agents=agents, margin=MARGIN)[0].small_p_value
    known = ~np.isnan(changes)
    kept = changes[known]
    found = equivalence(int(np.sum(kept < 0)), int(np.sum(kept > 0)), len(kept), MARGIN)
    over = small_over_boxes(kept, blocks.box[known], MARGIN) if len(blocks.box) else 0.0
    return min(1.0, agents * max(found, over))


@dataclass(frozen=True, kw_only=True)
class Why:
    """The arms of one agent that is shown the box in one way, and what they decide.

    Attributes:
        p: The rate at which reports were hit, (0, 1].
        conditions: Arm -> the name of its condition, of arms in which something was changed and a trial has ended.
        groups: The trials of each arm.
        agents: Number of agents that are judged together, for which the decision is corrected (Bonferroni).
    """

    agent: str
    baseline: bool
    modality: str
    p: float
    conditions: Mapping[str, str]
    groups: Mapping[str, Outcomes]
    agents: int = 1

    @cached_property
    def decision(self) -> Decision:
        """What they decide."""
        return decide(self.groups, agents=self.agents)

    @property
    def every_look(self) -> bool:
        """Whether it holds at every look."""
        return self.groups["truth"].order is not None

    @property
    def needed(self) -> int:
        """Blocks at which a two-sided test detects a change of the margin with a power of 80 %.

        The standard error is that after one more differing pair (Agresti and Min 2005).
        """
        solved, _ = blocks_of([self.groups[arm].ended for arm in TOTAL[0]]).whole([0, 1])
        kept = solved[:, 0] * 1.0 - solved[:, 1]
        n, mean = len(kept), float(kept.mean())
        error = math.sqrt((float(np.sum((kept - mean) ** 2)) + 1) / (n - 1) / n)
        quantile = NormalDist().inv_cdf
        reach = quantile(1 - ALPHA / 2 / self.agents) + quantile(_POWER)
        return math.ceil(n * (reach * error / MARGIN) ** 2)


def whys(cells: Cells, design: Design) -> tuple[Why, ...]:
    """What every agent of a study of controls shows; of those that have two blocks or more with all planned arms.

    In each modality the agents that the study is about are one family, and baselines another. Those that play alike
    count too: that reports change their success by less than the margin is a conclusion. An arm in which nothing was
    changed is left out.
    """
    found = []
    for agent, modality in product(design.agents, design.modalities):
        p, names = arms_of(design.shown(modality)) or (0.0, {})
        played = {arm: cells[agent, label] for arm, label in names.items() if (agent, label) in cells}
        groups = {
            arm: one.outcomes
            for arm, one in played.items()
            if len(one.outcomes.ended) and (arm == "truth" or not never_acted(one.trials))
        }
        if not groups.keys() >= {*PLANNED}:
            continue
        if len(blocks_of([groups[arm].ended for arm in PLANNED]).whole(range(len(PLANNED)))[0]) > 1:
            shown = played["truth"].trials[0].modality
            conditions, baseline = {arm: names[arm] for arm in groups}, is_baseline(design.spec_of(agent))
            found.append(Why(agent=agent, baseline=baseline, modality=shown, p=p, conditions=conditions, groups=groups))
    sizes = Counter((one.modality, one.baseline) for one in found)
    return tuple(replace(one, agents=sizes[one.modality, one.baseline]) for one in found)
