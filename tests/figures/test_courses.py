"""The panels of courses are the numbers of the summary."""

import numpy as np
from drawn import bars

from lockprobe import figures
from lockprobe.prose.success import course_said


def test_success_and_loops_stand_with_their_intervals(axes, typical):
    agent = typical.agents[0]
    figures.draw_course(axes, agent)
    shares = [[c.success for c in agent.conditions], [c.behaviour.loops for c in agent.conditions]]
    expected = [(share.value, share.low, share.high) for found in shares for share in found]
    assert np.allclose([bar[1:] for bar in bars(axes)], expected)
    assert np.allclose([bar[0] for bar in bars(axes)], [c.p for c in agent.conditions] * 2)


def test_the_course_is_named(axes, typical):
    for agent in typical.agents:
        figures.draw_course(axes, agent)
        kind = "the same at every flip rate" if agent.blind else course_said(agent.inference.course.kind)
        assert kind in " ".join(axes.get_title(loc="left").split("\n"))


def test_every_agent_has_a_panel(typical):
    made = figures.pictures(typical)["courses"]
    assert len([axes for axes in made.axes if axes.get_visible()]) == len(typical.agents)
