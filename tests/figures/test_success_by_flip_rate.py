"""Figures of success by flip rate show the shares, fits and best flip rates of the summary."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from drawn import bars, dots, labelled, lines, published, shades

from lockprobe import figures
from lockprobe.analysis.summary import summarise
from lockprobe.formatting import p_value
from lockprobe.lockbox.families import box

FALL = ((0.0, 28), (0.2, 15), (0.4, 3), (0.6, 15), (0.8, 28))
"""Flip rates, and how many of 30 trials are solved: a fall and a rise."""


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


def test_the_papers_own_figures_are_drawn_as_hollow_stars_with_one_name(axes, typical):
    figures.draw_success_by_p(axes, typical)
    assert published(axes) == ([(0.0, 7 / 30), (0.4, 20 / 30)], ["the paper"])
    (stars,) = [line for line in axes.lines if line.get_gid() == "paper"]
    assert (stars.get_marker(), stars.get_markerfacecolor(), stars.get_linestyle()) == ("*", "none", "None")


def test_a_star_whose_flip_rate_the_study_has_not_is_left_out(axes, typical, studies):
    higher = [replace(a, conditions=a.conditions[1:4]) for a in typical.agents]
    for found in (studies["one p"], studies["errors"], replace(typical, agents=tuple(higher))):
        figures.draw_success_by_p(axes, found)
        assert published(axes) == ([], [])
        axes.clear()


def test_bars_and_model_of_figure_4(axes, typical, model):
    figures.draw_success_by_p_corrected(axes, model, typical.reference)
    shares = [(c.p, c.success.value, c.success.low, c.success.high) for c in model.conditions]
    assert np.allclose(bars(axes), shares)
    curve = model.inference.orders.curve
    assert labelled(axes, "binomial model with 95 % band") == (list(curve.p), list(curve.value))
    (band,) = shades(axes)
    assert band >= set(zip(curve.p, curve.low, strict=True)) | set(zip(curve.p, curve.high, strict=True))
    assert f"order {model.inference.orders.order} (AICc)" in axes.get_title(loc="left")


def test_chance_is_that_of_the_last_step(axes, typical, model):
    figures.draw_success_by_p_corrected(axes, model, typical.reference)
    levels = {line.get_linestyle(): line.get_ydata()[0] for line in axes.lines if line.get_linestyle() in {":", "--"}}
    assert levels == {":": typical.reference.random[20], "--": typical.reference.no_repeat[20]}
    assert {"random\n39 %", "no-repeat\n69 %"} == {text.get_text() for text in axes.texts}


def test_the_figure_has_the_p_value_of_the_table(axes, model):
    """A fall and rise is no rise and fall: the test of this shape has P = 1, whatever the two lines have."""
    falls = [
        make_trial(SOLUTION if i < n else (0,) * 20, agent="llm:x", p=p, trial=i + 1)
        for p, n in FALL
        for i in range(30)
    ]
    other = summarise(falls, box("chain-4")).agents[0]
    assert other.inference.lines.p_value < 0.05
    for agent in (model, other):
        (table,) = [t.p_value for t in agent.inference.tests if (t.question, t.recommended) == ("shape", True)]
        figures.draw_success_by_p_corrected(axes, agent)
        assert p_value(table, "$P$").replace(" ", "\N{NO-BREAK SPACE}") in axes.get_title(loc="left")
        axes.clear()
    assert table == 1


def test_marks_of_the_peak(axes, model):
    figures.draw_success_by_p_corrected(axes, model)
    members, heights = labelled(axes, "95 % set of the best flip rate")
    assert members == [candidate.p for candidate in model.peak.candidates if candidate.in_set]
    assert 0 < len(members) < 7
    assert axes.get_ylim()[0] < max(heights) < 0
    (x,), (y,) = labelled(axes, "highest share, corrected for selection")
    assert y == model.peak.honest
    assert x == pytest.approx(model.peak.best, abs=0.03)


def test_two_flip_rates_cannot_tell_a_rise_and_a_fall_and_the_figure_says_so(axes, studies):
    agent = next(agent for agent in studies["few people"].agents if not agent.blind)
    assert len(agent.peak.candidates) == 2
    figures.draw_success_by_p_corrected(axes, agent)
    said = axes.get_title(loc="left").replace("\n", " ")
    assert said.endswith("rise and fall: not tested, needs three flip rates")


def test_what_is_not_there_is_not_drawn(axes, studies):
    agent = studies["one trial"].agents[0]
    assert agent.inference.orders.curve is None
    assert agent.peak.honest is None
    figures.draw_success_by_p_corrected(axes, agent)
    assert not shades(axes)
    assert axes.get_legend_handles_labels()[1] == ["share solved with 95 % Wilson interval"]


def test_a_blind_agent_has_no_model_of_p(axes, studies):
    blind = next(agent for agent in studies["strategies"].agents if agent.blind)
    figures.draw_success_by_p_corrected(axes, blind)
    assert len(bars(axes)) == 7
    assert not shades(axes)
    assert "the same at every flip rate" in axes.get_title(loc="left")
