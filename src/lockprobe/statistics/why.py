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

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Literal

from lockprobe.statistics.blocks import blocks_of, contrast
from lockprobe.statistics.contrast import Cells
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.design import PLANNED, Design, arms_of
from lockprobe.statistics.outcomes import Outcomes, never_acted
from lockprobe.statistics.proportions import Difference
from lockprobe.trial.condition import Contrast

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

TOTAL = Contrast(of=("lie",), minus=("truth",))
"""The total effect."""

CONTRASTS: Mapping[str, Contrast] = {
    name: Contrast(of=tuple(more.split()), minus=tuple(less.split()))
    for name, more, less in (
        ("false last after true", "truth-lie", "truth-truth"),
        ("false last after false", "lie-lie", "lie-truth"),
        ("false first before true", "lie-truth", "truth-truth"),
        ("false first before false", "lie-lie", "truth-lie"),
        ("both false", "lie-lie", "truth-truth"),
        ("interaction", "lie-truth truth-lie", "truth-truth lie-lie"),
        ("true correction", "truth-truth", "truth"),
        ("remark", "remark", "truth"),
    )
}
"""Contrasts of arms, whose mean is asked for. The interaction is half of FT + TF - TT - FF."""

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
        verdict: The conclusion.
        contrasts: Contrast of arms -> its mean over blocks; none unless the total effect is detected.
        claims: The claims that hold; none unless the total effect is detected.
    """

    total: Difference
    verdict: Verdict
    contrasts: Mapping[str, Difference] = field(default_factory=dict)
    claims: tuple[Claim, ...] = ()

    @property
    def way(self) -> int:
        """The direction of the total effect, 1 or -1."""
        return 1 if self.total.value > 0 else -1

    def goes(self, name: str) -> bool:
        """Whether a contrast is detected in this direction; a minus sign before it turns it round."""
        found, way = self.contrasts.get(name.removeprefix("-")), -self.way if name.startswith("-") else self.way
        return found is not None and found.detected(PART) and found.value * way > 0


def decide(groups: Mapping[str, Outcomes], *, agents: int = 1) -> Decision:
    """The decision from the trials of the arms, of so many agents that are judged together (Bonferroni).

    The arms are those of :data:`~lockprobe.statistics.design.PLANNED`, and ``remark`` for a claim on the form. A change
    is less than the margin if the whole interval is.
    """
    total = contrast(groups, TOTAL, choices=agents)
    if not total.detected():
        small = total.low is not None and total.high is not None and max(-total.low, total.high) < MARGIN
        return Decision(total=total, verdict="no change" if small else "inconclusive")
    contrasts = {
        name: contrast(groups, one, choices=agents)
        for name, one in CONTRASTS.items()
        if {*one.of, *one.minus} <= groups.keys()
    }
    found = Decision(total=total, verdict="not decided", contrasts=contrasts)
    held = [claim for claim, needs in NEEDS.items() if all(map(found.goes, needs))]
    # one false statement does more than two, by over a quarter of what two do: then the statements' disagreement itself
    # acts, which a plain false report has not
    one = (contrasts["false first before true"].value + contrasts["false last after true"].value) / 2
    both = found.way * contrasts["both false"].value
    if "contradiction" in held and found.way * one - both > max(0.0, both) / 4:
        held.remove("contradiction")
    if "agreed" in held and any(map(found.goes, _OTHERS)):
        held.remove("agreed")
    if any(claim in held for claim in CONTENT[:-1]):
        held = [claim for claim in held if claim != "falsity"]
    says, form = any(claim in CONTENT for claim in held), "form" in held
    verdict: Verdict = "blurred" if found.goes("true correction") else "not decided"
    if says or form:
        verdict = "both" if says and form else "says" if says else "form"
    return Decision(total=total, verdict=verdict, contrasts=contrasts, claims=tuple(held))


Why = tuple[str, str, float, Mapping[str, str], int, Decision]
"""Agent, modality, the rate at which reports were hit, arm -> the name of its condition (of arms in which something was
changed and a trial has ended), how many agents are judged together, and what was decided."""


def whys(cells: Cells, design: Design) -> Iterator[Why]:
    """What every agent of a study of controls shows; of those that have two blocks or more with all planned arms.

    In each modality the agents that the study is about are one family, and baselines another. Those that play alike
    count too: that reports change their success by less than the margin is a conclusion. An arm in which nothing was
    changed is left out.
    """
    found = []
    for agent, modality in product(design.agents, design.shown):
        p, names = arms_of(design.shown[modality]) or (0.0, {})
        played = {arm: cells[agent, label] for arm, label in names.items() if (agent, label) in cells}
        groups = {
            arm: one.outcomes
            for arm, one in played.items()
            if len(one.outcomes.ended) and (arm == "truth" or not never_acted(one.trials))
        }
        if groups.keys() >= {*PLANNED}:
            whole, _ = blocks_of([groups[arm].ended for arm in PLANNED]).whole(range(len(PLANNED)))
            shown, family = played["truth"].trials[0].modality, (modality, is_baseline(design.spec_of(agent)))
            found += [(family, agent, shown, p, {arm: names[arm] for arm in groups}, groups)] * (len(whole) > 1)
    sizes = Counter(family for family, *_ in found)
    for family, agent, shown, p, conditions, groups in found:
        yield agent, shown, p, conditions, sizes[family], decide(groups, agents=sizes[family])
