"""Figures draw the numbers of the summary, for any shape of study, and touch no global state."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from builders import make_trial, play_study, small_study
from matplotlib.figure import Figure

from lockprobe import figures
from lockprobe.analysis.summary import summarise

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
FOUR = ("random", "random-no-repeat", "round-robin", "human-inspired")


@pytest.fixture(scope="module")
def study():
    return summarise(play_study(small_study()))


def every_picture(summary):
    return [
        figures.single(figures.draw_success_by_p, summary),
        figures.single(figures.draw_success_curves, summary),
        figures.panels(figures.draw_success_curves_by_p, summary.subjects),
        figures.panels(figures.draw_loops_against_success, summary.subjects, "a note"),
        figures.panels(figures.draw_loops_by_p, summary.subjects),
    ]


@pytest.mark.parametrize("shape", [(["human-inspired"], P7), (FOUR, (0.0, 0.4, 1.0)), (["random"], (0.0,))])
def test_any_shape_of_study_can_be_drawn(shape):
    agents, p = shape
    for figure in every_picture(summarise(play_study(small_study(agents, p, 2, 2)))):
        assert figures.render(figure, "png").startswith(b"\x89PNG")


def test_nothing_solved_and_errors_can_be_drawn():
    failed = [make_trial([0] * 20, agent="llm:local", p=p, trial=i) for p in (0.0, 0.3, 0.6) for i in (1, 2)]
    broken = make_trial([0], agent="llm:x/y", p=0.0, broken="model")
    for figure in every_picture(summarise([*failed, broken])):
        assert figures.render(figure, "svg")


def test_hostile_names_are_drawn_as_text():
    names = ("llm:$\\frac{", "python:" + "x" * 200, "_hidden\n<script>")
    trials = [make_trial([3, 2, 1, 0], agent=name, p=p) for name in names for p in (0.0, 0.5)]
    for figure in every_picture(summarise(trials)):
        assert b"<script>" not in figures.render(figure, "svg")


def test_markers_of_success_are_the_pooled_shares(study):
    axes = Figure().add_subplot()
    figures.draw_success_by_p(axes, study)
    drawn = [np.asarray(container.lines[0].get_ydata()) for container in axes.containers]
    expected = [[c.success.value for c in agent.conditions] for agent in study.agents]
    assert len(drawn) == len(expected)
    assert all(any(np.allclose(one, other) for one in drawn) for other in expected)


def test_curves_are_those_of_the_lowest_p(study):
    axes = Figure().add_subplot()
    figures.draw_success_curves(axes, study)
    staircases = [np.asarray(line.get_ydata()) for line in axes.lines if line.get_drawstyle() == "steps-post"]
    for agent, drawn in zip(study.agents, staircases, strict=True):
        assert np.allclose(drawn[:-1], agent.conditions[0].curve.share)


def test_loop_rates_stand_beside_both_chance_levels(study):
    axes = Figure().add_subplot()
    agent = study.agents[1]
    figures.draw_loops_by_p(axes, agent)
    handles, names = axes.get_legend_handles_labels()
    assert names == ["chance, uniform", "chance, no immediate repeat", "observed"]
    found = [c.behaviour for c in agent.conditions]
    assert np.allclose(handles[0].get_ydata(), [b.chance_uniform for b in found])
    assert np.allclose(handles[1].get_ydata(), [b.chance_no_repeat for b in found])
    assert np.allclose(handles[2].lines[0].get_ydata(), [b.loops.value for b in found])


def test_dots_of_figure_5a_are_the_repetitions(study):
    axes = Figure().add_subplot()
    agent = study.agents[1]
    figures.draw_loops_against_success(axes, agent)
    dots = {tuple(map(float, place)) for place in axes.collections[0].get_offsets()}
    assert dots == {(point.loop_rate, point.success) for point in agent.points}
    assert axes.collections[0].get_sizes().sum() == 34 * len(agent.points)


def test_labels_never_touch(study):
    axes = Figure().add_subplot()
    figures.draw_success_by_p(axes, summarise(play_study(small_study(FOUR, (0.0, 0.5), 1, 2))))
    heights = sorted(text.get_position()[1] for text in axes.texts)
    assert len(heights) == 4
    assert all(b - a > 0.06 for a, b in pairwise(heights))


def test_equal_figures_are_equal_bytes(study):
    first, second = (figures.render(figures.single(figures.draw_success_by_p, study), "svg") for _ in range(2))
    assert first == second


def test_pyplot_is_not_used(study):
    every_picture(study)
    assert "matplotlib.pyplot" not in sys.modules


def test_a_blind_agent_has_one_curve(study):
    axes = Figure().add_subplot()
    figures.draw_success_curves_by_p(axes, study.agents[0])
    assert [text.get_text() for text in axes.texts] == ["every p"]
