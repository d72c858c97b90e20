"""Figures of loops show the loop rates, chance levels and odds ratios of the summary."""

import numpy as np
import pytest
from drawn import bars, dots, lines, published, shades, staircases

from lockprobe import figures


def test_odds_of_solving_after_a_loop(axes, model):
    figures.draw_loop_harm(axes, model)
    found, drawn = model.inference, [x.tolist() for x, _ in lines(axes)]
    effects = [found.hazard, found.landmark]
    expected = [part for effect in effects for part in ([effect.low, effect.high], [effect.odds_ratio])]
    twins = [[effect.blind.odds_ratio] for effect in effects]
    assert drawn == [*expected, [found.whole.odds_ratio], *[[1, 1]] * 3, *twins]
    assert "blind agent" in axes.get_title(loc="left")
    assert axes.get_xscale() == "log"
    low, high = axes.get_xlim()
    assert low * high == pytest.approx(1)
    assert low < found.whole.odds_ratio
    assert "n = 210 trials" in axes.get_title(loc="left")


def test_all_agents_have_one_axis_of_odds(studies):
    made = figures.pictures(studies["three"])["fig5a-corrected"]
    limits = {axes.get_xlim() for axes in made.axes if axes.get_visible()}
    assert len(made.axes) > 1
    assert len(limits) == 1


def test_the_naive_ratio_is_hollow_and_named(axes, model):
    figures.draw_loop_harm(axes, model)
    marks = [line for line in axes.lines if line.get_marker() == "o"]
    assert [mark.get_markerfacecolor() == "white" for mark in marks] == [False, False, True]
    assert [text.get_text().startswith("naive") for text in axes.texts[::2]] == [False, False, True]


def test_a_ratio_of_nothing_is_an_arrow_and_what_is_undefined_is_said(axes, studies):
    trapped = studies["three"].agents[1]
    assert trapped.inference.whole.odds_ratio == 0
    figures.draw_loop_harm(axes, trapped)
    (arrow,) = (line for line in axes.lines if line.get_marker() == "<")
    assert (arrow.get_marker(), arrow.get_xdata()[0]) == ("<", axes.get_xlim()[0])


def test_undefined_ratios_are_said(axes, studies):
    figures.draw_loop_harm(axes, studies["nothing solved"].agents[0])
    assert [text.get_text() for text in axes.texts[1::2]] == ["not defined", "not defined", "not defined, $P$ = 1"]
    assert [x.tolist() for x, _ in lines(axes)] == [[1, 1]] * 3


def test_loop_rates_stand_beside_four_levels_of_chance(axes, model):
    figures.draw_loops_with_chance(axes, model)
    found = [condition.behaviour for condition in model.conditions]
    expected = [(c.p, b.loops.value, b.loops.low, b.loops.high) for c, b in zip(model.conditions, found, strict=True)]
    assert np.allclose(bars(axes), expected)
    (band,) = shades(axes)
    for levels in ([b.chance_uniform for b in found], [b.chance_no_repeat for b in found]):
        assert band >= set(zip([c.p for c in model.conditions], levels, strict=True))
    drawn = {line.get_linestyle(): line.get_ydata() for line in axes.lines if line.get_linestyle() in {":", "--"}}
    assert list(drawn[":"]) == [b.chance_uniform for b in found]
    assert list(drawn["--"]) == [b.chance_no_repeat for b in found]
    marked = {line.get_marker(): list(line.get_ydata()) for line in axes.lines}
    assert marked["x"] == [b.chance_markov for b in found]
    assert marked["+"] == [b.chance_permutation for b in found]
    assert [text.get_text() for text in axes.texts] == ["random", "no-repeat"]


def test_chance_can_be_seen_at_a_single_p(axes, studies):
    agent = studies["one p"].agents[0]
    figures.draw_loops_with_chance(axes, agent)
    drawn = {line.get_linestyle(): line for line in axes.lines}
    assert list(drawn[":"].get_ydata()) == [agent.conditions[0].behaviour.chance_uniform] * 2
    low, high = drawn[":"].get_xdata()
    assert low < 0 < high


def test_loop_onset_of_the_lowest_p_against_all_higher(axes, model):
    figures.draw_loop_onset(axes, model)
    found = model.inference.onset.primary
    groups = [found.lowest, found.higher]
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [group.curve.share for group in groups]
    for band, group in zip(shades(axes), groups, strict=True):
        assert band >= set(enumerate(group.curve.low)) | set(enumerate(group.curve.high))
    said = axes.get_title(loc="left").replace("\N{NO-BREAK SPACE}", " ")
    assert f"hazard ratio {found.hazard_ratio:.2f}, log-rank: $P$ = {found.p_value:.2g}" in said
    assert {text.get_text() for text in axes.texts} == {"$p$ = 0\nn = 30", "$p$ = 0.1 to 0.6\nn = 180"}


@pytest.mark.parametrize(
    ("case", "why"), [("strategies", "the same at every flip rate"), ("one p", "fewer than two flip rates")]
)
def test_where_there_is_nothing_to_compare_that_is_said(axes, studies, case, why):
    figures.draw_loop_onset(axes, studies[case].agents[0])
    (text,) = axes.texts
    assert why in text.get_text().replace("\n", " ")
    assert not axes.lines


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


def test_the_papers_loop_rates_are_hollow_stars(axes, studies, model):
    for agent in (model, studies["nothing solved"].agents[0]):  # of which 0.4 lies between 0.3 and 0.6
        figures.draw_loops_by_p(axes, agent)
        assert published(axes) == ([(0.0, 0.8), (0.4, 16 / 30)], ["the paper, reconstructed"])
        axes.clear()
