"""The panels of courses are the numbers of the results."""

import numpy as np
from drawn import bars

from lockprobe.figures.courses import courses, draw_course


def test_success_and_loops_stand_with_their_intervals(axes, model):
    draw_course(axes, model)
    shares = [(cell.p, cell.get(quantity)) for quantity in ("success", "loop_rate") for cell in model.cells]
    assert np.allclose(bars(axes), [(p, share.value, share.low, share.high) for p, share in shares])


def test_the_course_is_named(axes, typical):
    said = set()
    for course in typical.courses():
        draw_course(axes, course)
        kind = typical.fact("course of success", f"{course.label}, flip rate")
        assert kind in " ".join(axes.get_title(loc="left").split("\n"))
        said.add(kind)
    assert "the same at every flip rate" in said
    assert len(said) > 1


def test_every_agent_has_a_panel(typical, studies):
    assert len([axes for axes in courses(typical).axes if axes.get_visible()]) == len(typical.courses())
    assert courses(studies["one p"]) is None
    assert courses(studies["one trial"]) is None
