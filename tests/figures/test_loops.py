"""What stands beside Figs. 5a and 5b are the numbers of the summary."""

import numpy as np
import pytest
from drawn import bars, lines, shades, staircases

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
    figures.draw_loops_beside_chance(axes, model)
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
    figures.draw_loops_beside_chance(axes, agent)
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
