"""Sentences on why false reports change success: through what they say, or as any odd report does."""

from __future__ import annotations

from lockprobe.foundation.formatting import listed, p_value, percent, points, range_said
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why.arms import PARTS
from lockprobe.statistics.why.contrasts import Why
from lockprobe.statistics.why.mechanism import CONTENT, NEEDS, Decision

ARMS = {
    "truth": "every report is true",
    "lie": "the report is inverted",
    "truth-truth": "two statements: the truth, and the truth again as its correction",
    "lie-truth": "two statements: a lie, and the truth as its correction",
    "truth-lie": "two statements: the truth, and a lie as its correction",
    "lie-lie": "two statements: a lie, and the lie again as its correction",
    "remark": "an irrelevant sentence follows the true report",
    "false outcome": "the outcome is inverted, and all positions are true",
    "false position": "the position of the attempted joint is inverted, and the outcome is true",
    "phantom": "another joint seems to jump, and seems to come back",
    "hidden moves": "reports of moves alone are inverted",
    "invented moves": "reports of attempts that moved nothing alone are inverted",
    "withheld": "there is no report",
    "nudge": "a sentence names every action loop; reports are true",
    "lie in loops": "the report is inverted where the attempt continues an action loop",
}
"""What happens in an arm at the selected steps."""

_CLAUSES = {
    "last": "those whose last statement is false {way} it",
    "first": "those whose first statement is false {way} it",
    "agreed": "only those whose two statements are both false {way} it",
    "contradiction": "a single false statement is enough to {way} it",
    "falsity": "those whose two statements are both false {way} it, and which of the two counts is not decided",
}
"""Claim -> what it says of reports in two statements."""

_ONE_EXCEEDS = "a single false statement is enough to {way} it, and does more than two"
"""The clause where two false statements do it, and one of them does more."""

_FORM = "a true correction and an irrelevant remark {way} it too"

ASSUMED = (
    "This is shown with reports in two statements, \N{LEFT DOUBLE QUOTATION MARK}\N{HORIZONTAL ELLIPSIS} Correction: "
    "\N{HORIZONTAL ELLIPSIS}\N{RIGHT DOUBLE QUOTATION MARK}. It assumes that a plain false report acts as they do. A "
    "false report that contradicts an earlier one is a statement and a surprise at once, and no arm tells these apart."
)
"""The assumption under every sentence that names a mechanism."""


def mechanism_said(found: Why) -> str:
    """The verdict in one sentence: first through what, then which reports showed it."""
    decision, way = found.decision, _way(found)
    of = f"the success of {Subject.seeing(found.agent, found.modality).name}"
    change = f"False reports {way} {of}"
    if decision.verdict in ("says", "form", "both"):
        return f"{change} {_through(decision, way)}."
    if decision.verdict == "blurred":
        return f"{change}. How is not decided: a true correction does it as well, so corrections cannot show why."
    if decision.verdict == "not decided":
        return f"{change}. Whether through what they say or as any odd report does is not decided."
    if decision.verdict == "no change":
        return f"False reports change {of} by less than {100 * found.margin:.0f} points."
    large = f"a change of {100 * found.margin:.0f} points or more is not excluded"
    return f"Inconclusive: no effect of false reports on {of} was detected, and {large}."


def _way(found: Why) -> str:
    return "raise" if found.decision.way > 0 else "lower"


def _through(decision: Decision, way: str) -> str:
    """The coarse claim, and a clause for each of the finer ones."""
    claims = decision.claims
    content = [
        (_ONE_EXCEEDS if claim == "falsity" and decision.one_exceeds_both else _CLAUSES[claim]).format(way=way)
        for claim in claims
        if claim in CONTENT
    ]
    odd = _FORM.format(way=way)
    if not content:
        return f"as any odd report does: {odd}, so falsity is not needed"
    said = f"of reports in two statements, {listed(content)}"
    if "form" in claims:
        return f"both through what they say and as any odd report does: {said}; {odd}"
    return f"through what they say{' in several ways' * (len(content) > 1)}: {said}"


def why_said(found: Why) -> list[str]:
    """The verdict, its numbers, and how many blocks an inconclusive study would need."""
    decision = found.decision
    numbers = (
        f"{percent(found.success('truth').value)} of trials were solved with true reports, "
        f"{percent(found.success('lie').value)} with reports inverted at a rate of {found.p:g}: "
        f"{_size(decision.total)}."
    )
    if decision.total.blocks < (played := max(found.success(arm).n for arm in ("truth", "lie"))):
        numbers += (
            f" {decision.total.blocks} of {played} blocks have both trials; in the others one broke or is missing."
        )
    said = [mechanism_said(found), f"{numbers} {_crossing(found)}" if found.detected else numbers]
    if found.detected:
        said += [*_rests_on(found), *_correction(found), *_others(found)]
    else:
        said.append(
            "Two one-sided tests of a change of "
            f"{100 * found.margin:.0f} points or more in either direction give {p_value(decision.equivalence)}."
        )
    if decision.verdict == "inconclusive" and found.needed > decision.total.blocks:
        said.append(
            f"About {found.needed} blocks are needed to detect a change of {100 * found.margin:.0f} points with a "
            f"power of 80 %; this study has {decision.total.blocks}."
        )
    if decision.verdict == "not decided":
        said.append("A study of more blocks may decide it: lockprobe power why says how many.")
    if found.agents > 1:
        said.append(f"P values and intervals of differences are corrected for {found.agents} agents (Bonferroni).")
    return said


def _crossing(found: Why) -> str:
    """Success with reports in two statements."""
    shares = {arm: percent(found.success(arm).value) for arm in ("truth-truth", "lie-truth", "truth-lie", "lie-lie")}
    return (
        "With reports in two statements it is {truth-truth} if both are true, {lie-truth} if the first is false, "
        "{truth-lie} if the last is false and {lie-lie} if both are.".format(**shares)
    )


def _rests_on(found: Why) -> list[str]:
    """The sizes of the contrasts on which the claims rest."""
    contrasts = found.decision.contrasts
    names = dict.fromkeys(name.removeprefix("-") for claim in found.decision.claims for name in NEEDS[claim])
    if not names:
        return []
    said = "; ".join(f"{name} {_size(contrasts[name])}" for name in names)
    return [f"The claim rests on these differences: {said}."]


def _correction(found: Why) -> list[str]:
    """What a true correction does, where the verdict does not say it."""
    if found.decision.verdict != "says" or not found.decision.corrections_alone:
        return []
    size = _size(found.decision.contrasts["true correction"])
    said = f"A true correction changes success in the same direction: {size}."
    return [f"{said} So a report in two statements acts even if both are true."]


def _others(found: Why) -> list[str]:
    """Other changes of success in the same direction at the same steps, by interval and corrected test."""
    same = {
        one.arm: _size(change)
        for one in found.arms
        if (change := one.change) is not None
        and change.clear
        and change.p_value is not None
        and change.p_value < ALPHA
        and change.value * found.decision.way > 0
    }
    said = []
    for what, arms in (
        ("Other interventions at the same steps", ("withheld", "nudge")),
        ("Parts of a false report", PARTS),
    ):
        if named := [f"{arm} {same[arm]}" for arm in arms if arm in same]:
            said.append(f"{what} also {_way(found)} success: {'; '.join(named)}.")
    return said


def _size(found: BlockMean) -> str:
    return f"{points(found.value)} points ({range_said(found.low, found.high)[2:]}; {p_value(found.p_value)})"
