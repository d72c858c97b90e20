"""What stands beside Figs. 3 and 4 are the numbers of the summary."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from drawn import bars, labelled, lines, shades, staircases

from lockprobe import figures


def test_curves_stand_beside_the_exact_ones(axes, typical, model):
    figures.draw_success_curves_corrected(axes, typical)
    drawn = [tuple(line.get_ydata()[:-1]) for line in staircases(axes)]
    exact = [typical.reference.random, typical.reference.no_repeat]
    assert drawn == [*(agent.conditions[0].curve.share for agent in typical.agents), *exact]
    assert [line.get_linestyle() for line in staircases(axes)[-2:]] == [":", "--"]
    assert labelled(axes, "shortest plan: 4 steps")[0] == [4, 4]
    (band,) = shades(axes)
    curve = model.conditions[0].curve
    assert band >= set(enumerate(curve.low)) | set(enumerate(curve.high))


def test_a_box_that_is_not_known_has_no_exact_curves(axes, studies):
    figures.draw_success_curves_corrected(axes, studies["one trial"])
    assert len(lines(axes)) == len(staircases(axes)) == 1


def test_areas_between_chance_and_the_shortest_plan(axes, typical):
    figures.draw_relative_success(axes, typical)
    found = [agent.conditions[0].relative for agent in typical.agents]
    drawn = lines(axes)
    for i, (interval, mark, relative) in enumerate(zip(drawn[0:8:2], drawn[1:8:2], found, strict=True)):
        assert [x.tolist() for x, _ in (interval, mark)] == [[relative.low, relative.high], [relative.value]]
        assert {*interval[1], *mark[1]} == {i}
    assert [x.tolist() for x, _ in drawn[8:]] == [[0, 0], [1, 1]] * 4
    assert [text.get_text() for text in axes.texts][::2] == [agent.agent for agent in typical.agents]
    assert f"{found[0].value:.2f} [" in axes.texts[1].get_text()
    low, high = axes.get_xlim()
    assert low < min(0, *(relative.low for relative in found))
    assert high > max(1, *(relative.high for relative in found))


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


def test_a_curve_for_every_p(axes, model):
    figures.draw_success_curves_by_p(axes, model)
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [c.curve.share for c in model.conditions]
    names = {text.get_text(): text.get_position()[1] for text in axes.texts}
    assert set(names) == {f"$p$ = {c.p:g}" for c in model.conditions}
    assert all(b - a > 0.079 for a, b in pairwise(sorted(names.values())))
    banded = [model.contrast.baseline.curve, model.contrast.other.curve]
    assert all(band >= set(enumerate(curve.high)) for band, curve in zip(shades(axes), banded, strict=True))


def test_of_many_p_only_those_that_matter_are_named(axes, studies):
    agent = studies["thirty p"].agents[0]
    figures.draw_success_curves_by_p(axes, agent)
    assert len(staircases(axes)) == 30
    known = {f"$p$ = {p:g}" for p in (0, agent.contrast.other.p, 1)}
    assert {text.get_text() for text in axes.texts} == known
    assert len(known) == len(axes.texts) == 3


@pytest.mark.parametrize("count", [13, 200])
def test_any_number_of_p_can_be_drawn(model, count):
    conditions = tuple(replace(model.conditions[0], p=i / count) for i in range(count))
    many = replace(model, conditions=conditions, contrast=None)
    for draw in (figures.draw_success_curves_by_p, figures.draw_success_by_p_corrected):
        figure = figures.panels(draw, [many])
        figure.draw_without_rendering()
        assert figure.axes[0].get_position().width > 0.4


def test_a_blind_agent_has_one_curve(axes, studies):
    blind = next(agent for agent in studies["strategies"].agents if agent.blind)
    figures.draw_success_curves_by_p(axes, blind)
    assert len(staircases(axes)) == 1
    assert [text.get_text() for text in axes.texts] == ["all $p$"]
