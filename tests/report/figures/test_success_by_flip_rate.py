"""Figures of success by flip rate show the shares and fits of the results."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from drawn import bars, dots, lines, published, shades

from lockprobe.foundation.formatting import p_value
from lockprobe.report.figures.success_by_flip_rate import (
    draw_success_by_dose,
    draw_success_by_p,
    fig4,
    fig4_corrected,
)
from lockprobe.report.opened import open_study
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers

FALL = ((0.0, 28), (0.2, 15), (0.4, 3), (0.6, 15), (0.8, 28))
"""Flip rates, and how many of 30 trials are solved: a fall and a rise."""


def shares(course):
    return [cell.get("success") for cell in course.cells]


def title(axes):
    return axes.get_title(loc="left").replace("\n", " ")


def test_means_fit_and_repetitions_of_figure_4(typical, model):
    (axes,) = fig4(typical).axes
    drawn = lines(axes)
    for course in typical.courses():
        means = [share.value for share in shares(course)]
        assert any(len(y) == 7 and np.array_equal(y, means) for _, y in drawn), course.agent
    fit = model.curve("success_fit")
    curves = [(tuple(x), tuple(y)) for x, y in drawn if len(x) == len(fit.x)]
    assert curves == [(fit.x, fit.value)]  # references have none
    points = [(cell.p, success.value) for cell in model.cells for success, _ in cell.points]
    assert sum(dots(axes).values()) == len(points) == 21
    assert set(dots(axes)) == set(points)


def test_the_papers_own_figures_are_drawn_as_hollow_stars_with_one_name(typical):
    (axes,) = fig4(typical).axes
    assert published(axes) == ([(0.0, 7 / 30), (0.4, 20 / 30)], ["the paper"])
    (stars,) = [line for line in axes.lines if line.get_gid() == "paper"]
    assert (stars.get_marker(), stars.get_markerfacecolor(), stars.get_linestyle()) == ("*", "none", "None")


def test_a_star_whose_flip_rate_the_study_has_not_is_left_out(axes, typical, studies):
    higher = [replace(course, cells=course.cells[1:4]) for course in typical.courses()]
    for courses in (higher, *(studies[name].courses() for name in ("one p", "errors"))):
        draw_success_by_p(axes, courses)
        assert published(axes) == ([], [])
        axes.clear()


@pytest.mark.parametrize("name", ["one p", "errors"])
def test_without_two_flip_rates_or_an_ended_trial_nothing_is_drawn(studies, name):
    assert fig4(studies[name]) is None
    assert fig4_corrected(studies[name]) is None


def test_bars_and_model_of_figure_4(typical, model):
    (axes,) = fig4_corrected(typical).axes
    assert np.allclose(
        bars(axes), [(c.p, s.value, s.low, s.high) for c, s in zip(model.cells, shares(model), strict=True)]
    )
    curve = model.curve("success_model")
    assert any(np.array_equal(x, curve.x) and np.array_equal(y, curve.value) for x, y in lines(axes))
    assert "binomial model with 95 % band" in axes.get_legend_handles_labels()[1]
    (band,) = shades(axes)
    assert band >= set(zip(curve.x, curve.low, strict=True)) | set(zip(curve.x, curve.high, strict=True))
    assert f"order {model.value('success_model_order', 'AICc'):g} (AICc)" in title(axes)


def test_chance_is_that_of_the_last_step(axes, typical, model):
    draw_success_by_dose(axes, model)
    levels = {line.get_linestyle(): line.get_ydata()[0] for line in axes.lines if line.get_linestyle() in {":", "--"}}
    chance = [typical.curve("success_by_step", of=of).value[20] for of in ("uniform", "no-repeat")]
    assert [levels[":"], levels["--"]] == chance
    assert {"random\n39 %", "no-repeat\n69 %"} == {text.get_text() for text in axes.texts}


def test_the_figure_has_the_p_value_of_the_table(tmp_path, axes, model):
    """A fall and rise is no rise and fall: the test of this shape has P = 1, whatever the two lines have."""
    falls = [
        make_trial(SOLUTION if i < n else (0,) * 20, agent="human-inspired", p=p, trial=i + 1)
        for p, n in FALL
        for i in range(30)
    ]
    planned = small_study(["human-inspired"], [p for p, _ in FALL], 1, 30)
    (other,) = results_of(study_numbers(open_study(write_study(tmp_path / "study", planned, falls)))).courses()
    assert other.get("success_two_lines").p_value < 0.05
    assert other.get("test", "shape").p_value == 1
    for course in (model, other):
        draw_success_by_dose(axes, course)
        said = p_value(course.get("test", "shape").p_value, "$P$").replace(" ", "\N{NO-BREAK SPACE}")
        assert said in axes.get_title(loc="left")
        axes.clear()


def test_two_flip_rates_cannot_tell_a_rise_and_a_fall_and_the_figure_says_so(axes, studies):
    course = next(course for course in studies["few people"].courses() if not course.blind)
    draw_success_by_dose(axes, course)
    assert title(axes).endswith("rise and fall: not tested; needs three doses")


def test_what_is_not_there_is_not_drawn(axes, studies):
    (course,) = studies["one trial"].courses()
    assert course.curve("success_model") is None
    draw_success_by_dose(axes, course)
    assert not shades(axes)
    assert axes.get_legend_handles_labels()[1] == ["share solved with 95 % interval"]


def test_a_blind_agent_has_no_model_of_p(axes, studies):
    blind = next(course for course in studies["strategies"].courses() if course.blind)
    draw_success_by_dose(axes, blind)
    assert len(bars(axes)) == len(blind.cells)
    assert not shades(axes)
    assert "the same at every flip rate" in title(axes)
