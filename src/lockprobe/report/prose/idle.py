"""Sentences on interventions that changed nothing in a whole condition: no effect of them was tested."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.foundation.formatting import capital, listed
from lockprobe.report.prose.doses import at_dose
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.idle import Idle, Unheeded


def idle_said(idle: Sequence[Idle], agents: Sequence[str]) -> list[str]:
    """What changed nothing, a sentence for each set of agents, and one for interventions in conditions that act.

    Args:
        idle: What changed nothing for some agent.
        agents: The agents that the study is about; where it is so for all of them, they are not named.
    """
    found: dict[tuple[str, str], dict[str, int]] = {}
    for one in idle:
        if one.agent in agents:
            found.setdefault((one.intervention, one.condition), {})[one.agent] = one.steps
    whole: dict[tuple[str, ...], list[str]] = {}
    for (intervention, condition), steps in found.items():
        if not intervention:
            whole.setdefault(tuple(steps), []).append(condition)
    said = [
        f"{listed(names)} changed nothing{_for(who, agents)} "
        f"(0 of {sum(found['', name][agent] for name in names for agent in who)} steps), "
        f"so nothing is concluded from {'it' if len(names) == 1 else 'them'}."
        for who, names in whole.items()
    ]
    parts = [
        f"{intervention} changed nothing{_for(tuple(steps), agents)} under {condition} "
        f"(0 of {sum(steps.values())} steps), so nothing there is ascribed to it."
        for (intervention, condition), steps in found.items()
        if intervention
    ]
    return [*said, *parts]


def unheeded_said(unheeded: Sequence[Unheeded], agents: Sequence[str]) -> list[str]:
    """The conditions under which an agent chose as under the control, a sentence for each of these agents."""
    found: dict[tuple[str, str], list[str]] = {}
    for one in unheeded:
        if one.agent in agents:
            found.setdefault((one.agent, one.control), []).append(
                f"{one.condition} (which acted in {one.changed} steps)"
            )
    return [
        f"{agent} chose the same joints as under {control} in every trial under {listed(names)}."
        for (agent, control), names in found.items()
    ]


def _for(who: Sequence[str], agents: Sequence[str]) -> str:
    if len(agents) == len(who) > 1:
        return " for any agent"
    return "" if len(agents) == 1 else f" for {listed([Subject.of(agent).name for agent in who])}"


def idle_doses_said(agent: AgentSummary) -> str:
    """The doses at which nothing happened to an agent; empty if there are none."""
    if not agent.idle:
        return ""
    doses = listed([at_dose(one.dose, agent.axis) for one in agent.idle])
    steps = sum(one.steps for one in agent.idle)
    what = "no report was false" if agent.axis.kind == "flip" else "nothing was changed"
    who, which = subject_of(agent).name, "it" if len(agent.idle) == 1 else "them"
    return f"{capital(doses)}, {what} ({who}, {steps} steps), so nothing is concluded from {which}."
