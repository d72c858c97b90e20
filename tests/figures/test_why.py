"""The ladder has a rung for every arm, the bars their parts and intervals."""

import pytest
from matplotlib.figure import Figure
from why_answers import answer

from lockprobe.figures.why import draw_ladder, draw_parts


def drawn(draw, found):
    figure = Figure(figsize=(3.5, 2.9), layout="constrained")
    axes = figure.subplots()
    draw(axes, found)
    figure.draw_without_rendering()
    return axes


def test_the_ladder_has_a_rung_for_every_arm_in_order():
    axes = drawn(draw_ladder, answer(0.3, 0.1, others=("remark", "withheld")))
    assert [label.get_text() for label in axes.get_yticklabels()] == ["truth", "lie", "retracted", "remark", "withheld"]
    assert [text.get_text() for text in axes.texts] == ["20 %", "60 %", "30 %", "40 %", "40 %"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first is on top


@pytest.mark.parametrize(("says", "disturbs"), [(0.3, 0), (-0.15, 0), (0.4, -0.15), (0, 0)])
def test_bars_are_the_whole_and_its_parts_with_zero_in_the_middle(says, disturbs):
    axes = drawn(draw_parts, answer(says, disturbs))
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == pytest.approx([says + disturbs, says, disturbs])
    low, high = axes.get_ylim()
    assert -low == high > max(abs(height) + 0.05 for height in heights) * 0.99
