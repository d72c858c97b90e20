"""Speed: its rows say what the trials say, and its figure, table and sentence what the rows say."""

import pytest
from builders import play_study, small_study
from drawn import beside, shades, staircases
from reported import found_in

from lockprobe.report.questions.speed import draw
from lockprobe.statistics.outcomes import outcomes

PLANNED = small_study(["cognitive:perseverant", "random"], (0.0, 0.2, 0.4), 2, 8)


@pytest.fixture(scope="module")
def played():
    return play_study(PLANNED)


@pytest.fixture(scope="module")
def found(played, tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("speed"), PLANNED, played)


def test_steps_are_those_of_the_trials(found, played):
    """Without trials that broke the mean over all of them is that of their lengths."""
    for cell in found.cells:
        own = outcomes([one for one in played if (one.group, one.condition) == (cell.agent, cell.condition)])
        assert cell.value("mean_steps_all") == pytest.approx(own.length.mean())
        for part, share in (("half", 0.5), ("80 %", 0.8)):
            solved = sorted(own.length[own.solved].tolist())
            reached = -(-round(share * len(own) * 100) // 100)
            assert cell.value("steps_to_solve", part) == (solved[reached - 1] if len(solved) >= reached else None)
        curve = cell.curve("success_by_step")
        assert curve.value[-1] == own.solved.mean()
    (course, _) = found.courses()
    change = course.get("steps_difference", "higher")
    steps = [cell.value("mean_steps_all") for cell in course.cells]
    assert change.value == pytest.approx((steps[1] + steps[2]) / 2 - steps[0])
    assert change.low < change.value < change.high
    assert found.courses()[1].get("steps_difference", "higher") is None  # it plays alike whatever it is told


def test_the_figure_has_a_line_an_agent_with_a_band_about_those_that_the_study_is_about(found):
    (axes,) = draw(found).axes
    curves = [course.cells[0].curve("success_by_step") for course in found.courses()]
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [curve.value for curve in curves]
    assert beside(axes) == {*found.subjects, "random", "random agents, exact"}
    corners = set().union(*shades(axes))
    assert corners >= set(enumerate(curves[0].low)) | set(enumerate(curves[0].high))
    assert not corners >= set(enumerate(curves[1].high))
    for of in ("uniform", "no-repeat"):
        assert corners >= set(enumerate(found.curve("success_by_step", of=of).value))
