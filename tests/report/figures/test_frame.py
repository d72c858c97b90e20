"""Names, axes and looks that the figures share."""

from dataclasses import replace
from itertools import pairwise

import pytest
from drawn import course, touching
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import p_value
from lockprobe.report.figures.frame import agent_label, counts, label_right, p_axis, step_axis


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("llm:$\\frac{", "llm:\\$\\frac{"),
        ("_hidden\n<script>", " _hidden?<script>"),
        ("llm:\u4e2d", "llm:?"),
        ("python:" + "x" * 200, "python:" + "x" * 22 + "…"),
        ("llm:openai/gpt-4o-2024-08-06", "llm:openai/gpt-4o-2024-08-06"),
        ("llm:together/meta-llama/Llama-3.3-70B-Instruct", "…Llama-3.3-70B-Instruct"),
        ("cognitive:random-map?window=1&avoid=last&x=2", "…random-map?window=1…"),
        ("human-inspired:target-first?lapse=0.1&decay=0.5", "…target-first?lapse=0.1&decay…"),
    ],
)
def test_names_are_safe_to_set(name, label):
    assert agent_label(course(name)) == label


def test_a_modality_is_named_unless_it_is_the_usual_one():
    assert agent_label(course("x")) == "x"
    assert agent_label(course("x", "rgb", shown="RGB")) == "x (RGB)"
    assert agent_label(course("participant", "rgb", shown="RGB")) == "people (RGB)"


def test_counts_name_the_trials(model, studies):
    fewer = studies["one trial"].cells
    assert counts(model.cells) == "n = 30 trials"
    assert counts(fewer) == "n = 1 trial"
    assert counts([fewer[0], model.cells[1]]) == "n = 1 to 30 trials"
    assert counts([]) == "n = 0 trials"


def test_p_values_cannot_be_taken_for_flip_rates():
    assert [p_value(value, "$P$") for value in (0.0004, 0.0123, 1.0, None)] == [
        "$P$ < 0.001", "$P$ = 0.012", "$P$ = 1", "not tested",
    ]  # fmt: skip


def test_every_p_has_a_tick_and_names_only_where_they_fit(axes, model):
    values = (0.0, 0.01, 0.02, 0.5, 1.0)
    p_axis(axes, [replace(model.cells[0], dose=p) for p in values])
    assert tuple(axes.get_xticks()) == values
    assert [label.get_text() for label in axes.get_xticklabels()] == ["0", "", "", "0.5", "1"]


def test_numbers_of_steps_are_apart_whatever_the_budget():
    """On the narrowest axes that a figure has: two panels in a row, with names at the right edge."""
    for budget in (*range(1, 31), 40, 60, 99, 100):
        figure = Figure(figsize=(2.4, 2.0))
        axes = figure.add_axes((0.3, 0.2, 0.65, 0.7))
        step_axis(axes, budget, "")
        figure.draw_without_rendering()
        assert len(axes.get_xticks()) > 1
        assert touching(figure) == [], budget


def test_labels_at_the_right_are_apart_and_in_order(axes):
    heights = [0.5, 0.51, 0.5, 0.0, 1.0, 0.99]
    label_right(axes, [(y, str(i), "black") for i, y in enumerate(heights)])
    assert len(axes.lines) < len(heights)  # a name that stands where its line ends has no dash before it
    placed = sorted((text.get_position()[1], heights[int(text.get_text())]) for text in axes.texts)
    assert all(b - a > 0.079 for (a, _), (b, _) in pairwise(placed))
    assert [y for _, y in placed] == sorted(heights)
    assert placed[0][0] >= 0
    assert placed[-1][0] <= 1
