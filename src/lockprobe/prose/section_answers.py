"""One sentence for each section of a report, which stands in its heading."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.formatting import first_three, percent
from lockprobe.prose.doses import at_dose
from lockprobe.prose.subject import subject_of
from lockprobe.prose.success import courses_said

__all__ = ["section_answers"]


def section_answers(summary: StudySummary) -> dict[str, str]:
    """Section -> its answer in one sentence; sections without numbers are missing."""
    agents = [agent for agent in summary.subjects if any(one.success.n for one in agent.conditions)]
    if not agents:
        return {}
    first = next(one.p for one in agents[0].conditions if one.success.n)
    where = at_dose(first, summary.axis)
    found = {
        "side": _best(summary),
        "success": courses_said(summary, brief=True),
        "speed": _said(agents, "Speed between chance (0) and the shortest plan (1)", _relative),
        "loops": _said(agents, f"Trials with a loop {where}", _loops),
        "rational": _said(agents, f"Optimal actions {where}", _optimal),
        "tests": _tests(agents),
        "said": _said(agents, f"Steps misread {where}", _misread) or "No agent said what its actions did.",
        "conditions": f"{len(summary.agents)} agents, {len(summary.conditions)} rows.",
    }
    return {section: said for section, said in found.items() if said}


def _said(agents: Iterable[AgentSummary], what: str, number: Callable[[ConditionSummary], str]) -> str:
    """A number of each agent under its first condition."""
    parts = [
        f"{said} ({subject_of(agent).name})"
        for agent in agents
        if (one := next((one for one in agent.conditions if one.success.n), None)) and (said := number(one))
    ]
    return f"{what}: {first_three(parts)}." if parts else ""


def _relative(condition: ConditionSummary) -> str:
    return f"{condition.relative.value:.2f}".replace("-", "\N{MINUS SIGN}") if condition.relative else ""


def _loops(condition: ConditionSummary) -> str:
    return percent(condition.behaviour.loops.value) if condition.behaviour.loops.n else ""


def _optimal(condition: ConditionSummary) -> str:
    return percent(condition.rationality[0].optimal.value) if condition.rationality else ""


def _misread(condition: ConditionSummary) -> str:
    return percent(condition.claims.mean_rate) if condition.claims.mean_rate is not None else ""


def _best(summary: StudySummary) -> str:
    shares = [(one.success.value, one.agent) for one in summary.standings if one.success.n and one.success.value]
    best = max(shares, default=None)
    return f"{best[1]} has the highest success over all {summary.axis.name}s: {percent(best[0])}." if best else ""


def _tests(agents: Iterable[AgentSummary]) -> str:
    done = [
        t
        for agent in agents
        if not agent.blind
        for t in agent.inference.tests
        if t.recommended and t.p_value is not None
    ]
    shown = sum(bool(test.rejects) for test in done)
    return f"{shown} of {len(done)} valid tests reject their null hypothesis." if done else ""
