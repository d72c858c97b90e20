"""The course of success over p for every agent, with its loop rate, one small panel each."""

from __future__ import annotations

from matplotlib.axes import Axes

from lockprobe.analysis.summary import AgentSummary
from lockprobe.figures.frame import agent_label, counts, p_axis, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.figures.primitives import bars, means
from lockprobe.prose.success import course_said

__all__ = ["draw_course"]

_SUCCESS = Style(colour=SUBJECTS[0], marker="o", dash="-", lead=True)
_LOOPS = Style(colour=ACCENT, marker="s", dash=(0, (5, 1.5)), lead=True)


def draw_course(axes: Axes, agent: AgentSummary) -> None:
    """Success and loop rate by flip probability, with the course that the tests detect."""
    share_axis(axes, "share of trials")
    played = [condition for condition in agent.conditions if condition.success.n]
    p_axis(axes, agent.conditions, axis=agent.axis)
    x = [condition.p for condition in played]
    for style, shares, label in (
        (_SUCCESS, [condition.success for condition in played], "solved"),
        (_LOOPS, [condition.behaviour.loops for condition in played], "with an action loop"),
    ):
        means(axes, x, shares, style, line=True)
        bars(axes, x, shares, style, label=label)
    found = agent.inference.course
    kind = (
        f"the same at every {agent.axis.name}" if agent.blind else course_said(found.kind, agent.axis) if found else ""
    )
    title(axes, agent_label(agent), f"{kind}; {counts(played)} per {agent.axis.name}")
