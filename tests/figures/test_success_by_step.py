"""Figures of success by step show the curves, areas and reference values of the summary."""

from dataclasses import replace
from itertools import pairwise

import pytest
from drawn import labelled, lines, published, shades, staircases

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


def test_the_papers_steps_are_hollow_stars(axes, typical):
    figures.draw_success_curves(axes, typical)
    assert published(axes) == ([(9.0, 0.8), (11.0, 0.8), (15.0, 0.8)], ["the paper"])


def test_agents_with_different_numbers_of_trials_keep_the_stars(axes, typical):
    first, *others = typical.agents
    lowest, *higher = first.conditions
    fewer = replace(first, conditions=(replace(lowest, curve=replace(lowest.curve, n=7)), *higher))
    figures.draw_success_curves(axes, replace(typical, agents=(fewer, *others)))
    assert len(published(axes)[0]) == 3


def test_without_the_lowest_p_there_are_no_stars(axes, typical):
    higher = [replace(a, conditions=a.conditions[1:4]) for a in typical.agents]
    for agents in (higher, [*typical.agents[:1], *higher[1:]]):
        figures.draw_success_curves(axes, replace(typical, agents=tuple(agents)))
        assert published(axes) == ([], [])
        axes.clear()


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
