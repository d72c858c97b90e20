"""What was found, in plain words computed from the numbers, with no more than the numbers bear."""

from __future__ import annotations

from lockprobe.analysis.behaviour import Behaviour
from lockprobe.analysis.inference.course import CourseKind
from lockprobe.analysis.inference.verdict import Question
from lockprobe.analysis.proportions import Proportion
from lockprobe.analysis.summary import AgentSummary, StudySummary

__all__ = ["beside", "conclusions", "courses_said", "finding", "loop_finding"]


def finding(agent: AgentSummary) -> str:
    """What false reports did to one agent's success."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted:
        return f"No trial of {agent.agent} has ended as solved or out of budget."
    share, contrast = counted[0].success, agent.contrast
    if agent.blind:
        return f"{agent.agent} acted the same whatever it was told: it solved {_of(share)} under every condition."
    if contrast is None:
        why = (
            "With a single condition there is no difference to look for."
            if len(counted) == 1
            else "No trial has been played under two conditions yet."
        )
        return (
            f"{agent.agent} solved {_of(share)}, 95 % interval {_percent(share.low)} to {_percent(share.high)}. {why}"
        )
    first, second, found = contrast.baseline, contrast.other, contrast.difference
    subject = f"No effect of false reports on the success of {agent.agent} is detectable: it solved"
    if found.value == 0:
        return (
            f"{subject} {_percent(share.value)} of its trials under every condition (n = {share.n} at "
            f"p = {first.p:g}, 95 % interval {_percent(share.low)} to {_percent(share.high)})."
        )
    chosen = "" if contrast.choices == 1 else f", both corrected for choosing it from {contrast.choices}"
    interval = (
        f"{_points(found.value)} points, 95 % interval {_points(contrast.paired.low)} to "
        f"{_points(contrast.paired.high)}; permutation test, {_p(contrast.p_adjusted)}{chosen}"
    )
    if not contrast.detectable:
        return (
            f"{subject} {_of(first.success)} {_told(first.p)} and {_of(second.success)} {_told(second.p)}, "
            f"the largest difference ({interval}). That is not evidence that there is none."
        )
    verdict = "more" if found.value > 0 else "less"
    return (
        f"{agent.agent} solved the box {verdict} often {_told(second.p)} than {_told(first.p)}: "
        f"{_of(second.success)} against {_of(first.success)} ({interval})."
    )


def loop_finding(agent: AgentSummary) -> str:
    """How an agent's loop rate lies to chance, at its lowest p and at the p of its contrast."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    shown = [agent.contrast.baseline, agent.contrast.other] if agent.contrast else counted[:1]
    said = "; ".join(
        f"{_of(condition.behaviour.loops)} {_told(condition.p)}, {_against_chance(condition.behaviour)}"
        for condition in shown
    )
    return f"An action loop is in {said}." if said else ""


def conclusions(agent: AgentSummary) -> list[str]:
    """What the recommended tests say of the shape of success, of looping and of its harm, a sentence each."""
    if agent.blind or len([condition for condition in agent.conditions if condition.success.n]) < 2:
        return []
    tests = {test.question: test for test in agent.inference.tests if test.recommended}
    said = []
    for question, (yes, no) in _SAID.items():
        test = tests[question]
        if test.p_value is None:
            continue
        interval = "" if test.low is None or test.high is None else f" [{test.low:.2g}, {test.high:.2g}]"
        effect = "" if test.effect is None or question == "shape" else f"{test.unit} {test.effect:.2g}{interval}; "
        found = yes if isinstance(yes, str) else yes[test.direction > 0]
        sentence = found if test.rejects else no
        said.append(f"{sentence} ({effect}{test.name}, {_p(test.p_value)}).")
    return said


_SAID: dict[Question, tuple[str | tuple[str, str], str]] = {
    "speed": (
        (
            "False reports make the agent solve the box later or not at all",
            "False reports make the agent solve the box sooner",
        ),
        "That false reports change how fast the box is solved is not detectable",
    ),
    "shape": (
        "Success rises with false reports and falls again",
        "That success falls again at high p is not detectable",
    ),
    "looping": (
        (
            "False reports make the agent loop later or not at all",
            "False reports make the agent loop sooner",
        ),
        "That false reports change how soon the agent loops is not detectable",
    ),
    "harm": (
        (
            "After a loop the agent is less likely to solve the box",
            "After a loop the agent is more likely to solve the box",
        ),
        "That the agent solves the box less often after a loop is not detectable",
    ),
}
"""What a yes (less, more) and a no are in words."""


def beside(summary: StudySummary) -> str:
    """What the references reach at their lowest p; empty if the study has none beside its subjects."""
    shares = [
        f"{agent.agent} {_of(first.success)}"
        for agent in summary.agents
        if agent not in summary.subjects and (first := agent.conditions[0]).success.n
    ]
    return f"For comparison, {_told(summary.conditions[0].p)}: {', '.join(shares)}." if shares else ""


def courses_said(summary: StudySummary) -> str:
    """Which agents' success rises with false reports, which falls, which both; empty for one agent or one p."""
    heeding = [agent for agent in summary.agents if not agent.blind]
    shown = [p for agent in heeding for p in (condition.p for condition in agent.conditions if condition.success.n)]
    if len(summary.agents) < 2 or len(set(shown)) < 2:
        return ""
    courses = [(agent.agent, agent.inference.course.kind) for agent in heeding if agent.inference.course]
    kinds = dict.fromkeys(kind for _, kind in sorted(courses, key=lambda course: _COURSES.index(course[1])))
    parts = [f"{_SAID_OF[kind]} {', '.join(name for name, found in courses if found == kind)}" for kind in kinds]
    blind = [agent.agent for agent in summary.agents if agent.blind]
    parts += [f"is the same at every p for {', '.join(blind)}"] if blind else []
    return f"From p = {min(shown):g} to {max(shown):g} success {'; '.join(parts)}." if parts else ""


_SAID_OF: dict[CourseKind, str] = {
    "rises": "rises for",
    "falls": "falls for",
    "rises and falls": "rises and then falls for",
    "falls and rises": "falls and then rises for",
    "no change detectable": "does not change detectably for",
    "not tested": "is not tested for",
}
_COURSES = list(_SAID_OF)


def _against_chance(found: Behaviour) -> str:
    uniform, no_repeat = found.chance_uniform or 0.0, found.chance_no_repeat or 0.0
    low, high = min(uniform, no_repeat), max(uniform, no_repeat)
    verdict = (
        "more than chance"
        if found.loops.low > high
        else "fewer than chance"
        if found.loops.high < low
        else "not distinguishable from chance"
    )
    return f"{verdict} (random actions in trials of those lengths: {_percent(low)} to {_percent(high)})"


def _told(p: float) -> str:
    return "when told the truth" if p == 0 else f"when each report was inverted with probability {p:g}"


def _of(share: Proportion) -> str:
    return f"{share.count} of {share.n} trials ({_percent(share.value)})"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def _points(value: float) -> str:
    return f"{100 * value:+.0f}".replace("-", "\N{MINUS SIGN}")


def _p(value: float) -> str:
    return "p < 0.001" if value < 0.001 else f"p = {value:.2g}"
