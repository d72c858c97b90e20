"""The key numbers of an agent on the first screen: a card with its success, and what changed it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import cast

from lockprobe.agents.catalogue import description
from lockprobe.foundation.formatting import NONE, bracketed, share
from lockprobe.report.prose.doses import at_dose
from lockprobe.report.prose.readings import false_reports
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.conditions.effects import Effects
from lockprobe.statistics.inference.difference import DifferenceAt
from lockprobe.statistics.proportions import ALPHA, Paired
from lockprobe.statistics.why.contrasts import Why
from lockprobe.trial.condition import TRUTH


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyNumbers:
    """The numbers of one agent, as text with 95 % intervals; ``agents`` are judged together.

    ``open`` is a change that was not detected although its interval leaves out 0.
    """

    agent: str
    what: str
    success: str
    where: str
    change: str = NONE
    against: str = ""
    agents: int = 1
    open: bool = False


def axis_numbers(agent: AgentSummary) -> KeyNumbers:
    """Success at the first flip rate, and the change from it that was tested."""
    first, contrast = next(one for one in agent.conditions if one.success.n), agent.contrast
    found = first.success
    change, against, open_ = NONE, "", False
    if agent.blind:
        change, against = "0 points", "change: it plays alike whatever it is told"
    elif contrast is not None:
        gap, open_ = contrast.difference, _open(contrast.difference)
        change = f"{bracketed(gap.value, gap.low, gap.high)} points"
        start = "change " if contrast.choices == 1 else ""
        which = "" if contrast.choices == 1 else f", {'largest' if contrast.farthest else 'clearest'} change"
        options, of_flips = agent.axis.options, agent.axis.name == FLIPS.name
        kind = (f", {false_reports(options)}" if of_flips else f" ({options})") if options else ""
        doses = f"{contrast.baseline.dose:g} to {contrast.other.dose:g}"
        against = f"{start}from {agent.axis.name} {doses}{kind}{which}"
        against += "" if contrast.whole else f", of {gap.first.n} trials finished under both"
    return KeyNumbers(
        agent=subject_of(agent).name,
        what=description(agent.spec),
        success=share(found.value, found.low, found.high),
        where=f"of {found.n} trials solved {_under(first.name) or at_dose(first.dose, agent.axis)}",
        change=change,
        against=against,
        agents=contrast.agents if contrast else 1,
        open=open_,
    )


def _open(change: DifferenceAt | Paired | BlockMean) -> bool:
    """Whether a change was not detected although its interval leaves out 0."""
    if change.low is None or change.high is None or change.p_value is None:
        return False
    return (change.low > 0 or change.high < 0) and change.p_value >= ALPHA


def _under(condition: str) -> str:
    """What a condition of true reports is called on every card; empty for others."""
    return at_dose(0) if condition == TRUTH else ""


def why_numbers(found: Why, spec: str) -> KeyNumbers:
    """Success under true reports, and the planned comparison with lies."""
    truth, change = found.success("truth"), found.decision.total
    return KeyNumbers(
        agent=Subject.of(found.agent).name,
        what=description(spec),
        success=share(truth.value, truth.low, truth.high),
        where=f"of {truth.n} trials solved under true reports",
        change=f"{bracketed(change.value, change.low, change.high)} points",
        against="change under false reports",
        agents=found.agents,
        open=_open(change),
    )


def condition_numbers(found: Effects, spec: str) -> KeyNumbers:
    """Success under the control, and the clearest effect: of equal P values, the largest."""
    clearest = min(found.effects, key=lambda one: (one.difference.p_value, -abs(one.difference.value)))
    gap = clearest.difference
    return KeyNumbers(
        agent=Subject.of(found.agent).name,
        what=description(spec),
        success=share(gap.first.value, gap.first.low, gap.first.high),
        where=f"of {gap.first.n} trials solved {_under(found.control) or f'under {found.control}'}",
        change=f"{bracketed(gap.value, gap.low, gap.high)} points",
        against=f"{'clearest ' * (len(found.effects) > 1)}change under {clearest.condition}",
        agents=found.agents,
        open=_open(gap),
    )


def intervals_said(numbers: Sequence[KeyNumbers], *, every_look: bool) -> str:
    """What the intervals are, for how many looks they hold, and for what those of changes are corrected."""
    against, many = " ".join(row.against for row in numbers), max(row.agents for row in numbers)
    chosen = next((f"choosing the {which}" for which in ("largest", "clearest") if which in against), "")
    corrected = " and ".join(f"for {one}" for one in (chosen, f"{many} agents" * (many > 1)) if one)
    looks = "at every look" if every_look else "for one look, after all planned trials"
    return f"Brackets: 95 % intervals, {looks}{f'; changes: corrected {corrected}' if corrected else ''}."


def open_said(numbers: Sequence[KeyNumbers]) -> str:
    """Why a change was not detected although its interval excludes 0; empty without one."""
    return "A change whose interval excludes 0 is detected only if its test rejects, too." * any(
        row.open for row in numbers
    )


def cards_of(numbers: Iterable[dict[str, str]]) -> list[dict[str, object]]:
    """A card for each agent: every success once, with all changes from it."""
    cards: dict[str, dict[str, object]] = {}
    shares: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in numbers:
        card = cards.setdefault(row["agent"], {"agent": row["agent"], "what": row.get("what", ""), "shares": []})
        key = row["agent"], row["success"], row["where"]
        if key not in shares:
            shares[key] = []
            own = cast("list[dict[str, object]]", card["shares"])
            own.append({"success": row["success"], "where": row["where"], "changes": shares[key]})
        if row.get("against"):
            shares[key].append({"change": row["change"], "against": row["against"]})
    return list(cards.values())
