"""What else was found, in plain words: loops, tests, courses, modalities, a robot's verdicts."""

from __future__ import annotations

from lockprobe.analysis.behaviour import Behaviour
from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.inference.course import CourseKind
from lockprobe.analysis.inference.verdict import Question
from lockprobe.analysis.modalities import ModalityEffect, spoken
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.robot import Verdicts
from lockprobe.analysis.speaking import begun, called, of_people, of_trials, p_said, percent, test_said, told, verb
from lockprobe.analysis.summary import AgentSummary, StudySummary

__all__ = ["beside", "conclusions", "courses_said", "loop_finding", "modality_finding", "verdicts_said"]


def loop_finding(agent: AgentSummary) -> str:
    """How an agent's loop rate lies to chance, at its lowest p and at the p of its contrast."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    shown = [agent.contrast.baseline, agent.contrast.other] if agent.contrast else counted[:1]
    said = "; ".join(
        f"{of_trials(condition.behaviour.loops)} {told(condition.p)}, {_against_chance(condition.behaviour)}"
        for condition in shown
    )
    return f"An action loop is in {said}." if said else ""


def conclusions(agent: AgentSummary) -> list[str]:
    """What the recommended tests say of the shape of success, of looping and of its harm, a sentence each."""
    if agent.blind or len([condition for condition in agent.conditions if condition.success.n]) < 2:
        return []
    tests = {test.question: test for test in agent.inference.tests if test.recommended}
    said = []
    for question, words in _SAID.items():
        test = tests[question]
        if test.p_value is None:
            continue
        yes, no = words if test.baseline is None else _BESIDE_BLIND
        interval = "" if test.low is None or test.high is None else f" [{test.low:.2g}, {test.high:.2g}]"
        if test.baseline is not None:
            interval += f", of a blind agent with the same action habits {test.baseline:.2g}"
        effect = "" if test.effect is None or question == "shape" else f"{test.unit} {test.effect:.2g}{interval}; "
        found = yes if isinstance(yes, str) else yes[test.direction > 0]
        sentence = verb(agent.agent, found if test.rejects else no, of_people(found if test.rejects else no))
        said.append(f"{sentence} ({effect}{test_said(test.name)}, {p_said(test.p_value)}).")
    return said


_AS_THE_REST = "if trials that were solved would have gone on to loop like those still running"
"""What a log-rank test of loops assumes, which the records cannot show."""

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
        "That success falls again at high flip rates is not detectable",
    ),
    "looping": (
        (
            f"False reports make the agent loop later or not at all, {_AS_THE_REST}",
            f"False reports make the agent loop sooner, {_AS_THE_REST}",
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

_BESIDE_BLIND: tuple[str | tuple[str, str], str] = (
    (
        "After a loop the agent is less likely to solve the box than a blind agent with the same action habits",
        "After a loop the agent is more likely to solve the box than a blind agent with the same action habits",
    ),
    "That loops harm the agent beyond what its action habits and the mechanics of the box explain is not shown",
)
"""The same of harm where it is known what the box gives to a blind agent."""


def beside(summary: StudySummary) -> str:
    """What the references reach at their lowest p; empty if the study has none beside its subjects."""
    shares = [
        f"{agent.called} {of_trials(first.success)}"
        for agent in summary.agents
        if agent not in summary.subjects and (first := agent.conditions[0]).success.n
    ]
    return f"For comparison, {told(summary.conditions[0].p)}: {', '.join(shares)}." if shares else ""


def modality_finding(effect: ModalityEffect, summary: StudySummary) -> str:
    """What the way in which the box is shown did to one agent."""
    found = {agent.modality: agent.conditions[0] for agent in summary.agents if agent.agent == effect.agent}
    shown = "; ".join(
        f"{of_trials(found[modality].success)} with {spoken(modality)}, {_steps_to_80(found[modality])}"
        for modality in effect.modalities
    )
    return begun(f"{called(effect.agent)} solved {shown}. {_how_soon(effect)}")


def _how_soon(effect: ModalityEffect) -> str:
    """Of the trend over fidelity; of all modalities as they come where they have but one fidelity."""
    p_value = effect.p_value if effect.differs_in_fidelity else effect.p_all
    if p_value is None:
        return "These are too few trials to compare how soon."
    solves = verb(effect.agent, "it solves", "they solve")
    together = f"trials that share their luck kept together, {p_said(p_value)}"
    if not effect.differs_in_fidelity:
        what, how = "the way in which it is shown", f"log-rank over all of them, {together}"
        if p_value < ALPHA:
            return f"How soon {solves} the box differs with {what} ({how})."
    else:
        what, how = "fidelity", f"log-rank for a trend over fidelity, {together}"
        if effect.detectable:
            sooner = "sooner" if effect.direction > 0 else "later or more rarely"
            return f"The higher the fidelity, the {sooner} {solves} the box ({how})."
    return (
        f"That {what} changes how soon {solves} the box is not detectable ({how}); "
        "that is not evidence that it does not."
    )


def _steps_to_80(condition: ConditionSummary) -> str:
    step = condition.curve.steps_to(0.8)
    return "80 % not reached" if step is None else f"80 % by step {step}"


def verdicts_said(found: Verdicts) -> str:
    """How often a robot was wrong about what it had done."""
    wrong = found.wrong
    if not wrong.n:
        return f"The robot could tell nothing at any of {found.attempts} attempts."
    failed = f"; at {found.failed} more it could not tell" if found.failed else ""
    kinds = (
        f", {found.moved_for_blocked} of them took a blocked joint for moved, {found.blocked_for_moved} a moved one "
        "for blocked"
        if wrong.count
        else ""
    )
    return (
        f"The robot's own verdict, from force and way, was wrong at {wrong.count} of {wrong.n} attempts "
        f"({100 * wrong.value:.1f} %, 95 % interval {100 * wrong.low:.1f} to {100 * wrong.high:.1f} %){kinds}{failed}. "
        "Agents are not told it, and no number below rests on it."
    )


def courses_said(summary: StudySummary) -> str:
    """Which agents' success rises with false reports, which falls, which both; empty for one agent or one p."""
    heeding = [agent for agent in summary.agents if not agent.blind]
    shown = [p for agent in heeding for p in (condition.p for condition in agent.conditions if condition.success.n)]
    if len(summary.agents) < 2 or len(set(shown)) < 2:
        return ""
    courses = [(agent.called, agent.inference.course.kind) for agent in heeding if agent.inference.course]
    kinds = dict.fromkeys(kind for _, kind in sorted(courses, key=lambda course: _COURSES.index(course[1])))
    parts = [f"{_SAID_OF[kind]} {', '.join(name for name, found in courses if found == kind)}" for kind in kinds]
    blind = [agent.called for agent in summary.agents if agent.blind]
    parts += [f"is the same at every flip rate for {', '.join(blind)}"] if blind else []
    many = "" if len(courses) < 2 else f" (Holm, corrected for looking at {len(courses)} agents)"
    return f"From a flip rate of {min(shown):g} to {max(shown):g} success {'; '.join(parts)}{many}." if parts else ""


_SAID_OF: dict[CourseKind, str] = {
    "rises": "rises for",
    "falls": "falls for",
    "rises and falls": "rises and then falls for",
    "falls and rises": "falls and then rises for",
    "no change detectable": "is not shown to change for",
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
    return f"{verdict} (random actions in trials of those lengths: {percent(low)} to {percent(high)})"
