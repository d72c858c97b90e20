"""The paper's figures show the numbers of the summary, and nothing but the paper's."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import dots, lines, published, shades, staircases

from lockprobe import figures


def test_staircases_are_the_success_curves_without_bands(axes, typical):
    figures.draw_success_curves(axes, typical)
    for agent, line in zip(typical.agents, staircases(axes), strict=True):
        assert line.get_label() == agent.agent
        assert tuple(line.get_ydata()[:-1]) == agent.conditions[0].curve.share
        assert tuple(line.get_xdata()[:-1]) == tuple(range(21))
        assert line.get_ydata()[-1] == line.get_ydata()[-2]
    assert not axes.collections
    assert "flip rate 0; n = 30 trials" in axes.get_title(loc="left")


def test_means_fit_and_repetitions_of_figure_4(axes, typical, model):
    figures.draw_success_by_p(axes, typical)
    drawn = lines(axes)
    for agent in typical.agents:
        means = [condition.success.value for condition in agent.conditions]
        assert any(len(y) == 7 and np.array_equal(y, means) for _, y in drawn), agent.agent
    fit = model.success_fit.quadratic
    curves = [(x, y) for x, y in drawn if len(x) == len(fit.p)]
    assert len(curves) == 1  # references have none
    assert tuple(curves[0][0]) == fit.p
    assert tuple(curves[0][1]) == fit.value
    assert sum(dots(axes).values()) == len(model.points) == 21
    assert set(dots(axes)) == {(point.p, point.success) for point in model.points}


def test_the_band_of_a_fit_is_that_of_the_summary(axes, model):
    figures.draw_loops_by_p(axes, model)
    fit = model.loop_fit.quadratic
    (band,) = shades(axes)
    assert band >= set(zip(fit.p, fit.low, strict=True)) | set(zip(fit.p, fit.high, strict=True))


def test_loop_rates_of_figure_5b(axes, model):
    figures.draw_loops_by_p(axes, model)
    fit, drawn = model.loop_fit.quadratic, lines(axes)
    assert [tuple(y) for _, y in drawn] == [fit.value, tuple(c.behaviour.loops.value for c in model.conditions)]
    assert set(dots(axes)) == {(point.p, point.loop_rate) for point in model.points}


def test_dots_and_line_of_figure_5a(axes, model):
    figures.draw_loops_against_success(axes, model)
    assert set(dots(axes)) == {(point.loop_rate, point.success) for point in model.points}
    assert sum(dots(axes).values()) == len(model.points)
    x, y = np.array([(point.loop_rate, point.success) for point in model.points]).T
    ((ends, heights),) = lines(axes)
    assert np.allclose(heights, np.polyval(np.polyfit(x, y, 1), ends))
    assert ends.tolist() == [x.min(), x.max()]
    assert f"r = \N{MINUS SIGN}{-model.correlation.r:.2f} [" in axes.get_title(loc="left")
    assert "n = 21 repetitions" in " ".join(axes.get_title(loc="left").split())


def test_no_line_where_r_is_not_defined(axes, studies):
    figures.draw_loops_against_success(axes, studies["nothing solved"].agents[0])
    assert lines(axes) == []
    assert "r is not defined" in axes.get_title(loc="left")


@pytest.mark.parametrize("draw", [figures.draw_loops_against_success, figures.draw_loops_by_p])
def test_blind_agents_say_so(axes, studies, draw):
    blind = next(agent for agent in studies["strategies"].agents if agent.blind)
    draw(axes, blind)
    assert "random, the same at every flip rate" in axes.get_title(loc="left")


def test_a_fit_without_a_band_does_not_claim_one(axes, studies):
    agent = studies["one trial"].agents[0]
    assert agent.loop_fit.quadratic.low == ()
    figures.draw_loops_by_p(axes, agent)
    assert "second-order fit" in axes.get_title(loc="left")
    assert "band" not in axes.get_title(loc="left")


def test_the_papers_own_figures_are_drawn_as_hollow_stars_with_one_name(axes, typical):
    figures.draw_success_by_p(axes, typical)
    assert published(axes) == ([(0.0, 7 / 30), (0.4, 20 / 30)], ["the paper"])
    (stars,) = [line for line in axes.lines if line.get_gid() == "paper"]
    assert (stars.get_marker(), stars.get_markerfacecolor(), stars.get_linestyle()) == ("*", "none", "None")


def test_those_of_figures_3_and_5b(axes, typical, model):
    figures.draw_success_curves(axes, typical)
    assert published(axes) == ([(9.0, 0.8), (11.0, 0.8), (15.0, 0.8)], ["the paper"])
    axes.clear()
    figures.draw_loops_by_p(axes, model)
    assert published(axes) == ([(0.0, 0.8), (0.4, 16 / 30)], ["the paper, reconstructed"])


def test_where_the_study_has_no_place_for_them_they_are_left_out(axes, studies):
    figures.draw_success_by_p(axes, studies["one p"])
    assert published(axes) == ([], [])
    axes.clear()
    figures.draw_loops_by_p(axes, studies["nothing solved"].agents[0])
    assert published(axes) == (
        [(0.0, 0.8), (0.4, 16 / 30)],
        ["the paper, reconstructed"],
    )  # 0.4 lies between 0.3 and 0.6
    axes.clear()
    figures.draw_success_by_p(axes, studies["errors"])
    assert published(axes) == ([], [])


def test_a_fourth_figure_without_the_lowest_p_has_no_star_there(axes, typical):
    higher = [replace(a, conditions=a.conditions[1:4]) for a in typical.agents]
    figures.draw_success_by_p(axes, replace(typical, agents=tuple(higher)))
    assert published(axes) == ([], [])
    axes.clear()
    figures.draw_success_curves(axes, replace(typical, agents=tuple(higher)))
    assert published(axes) == ([], [])
