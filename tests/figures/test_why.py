"""The ladder has a rung for every arm, the bars their parts and intervals."""

import pytest

from lockprobe.analysis.proportions import proportion
from lockprobe.figures.why import why
from lockprobe.rows import Estimate, Results

AGENT = {"agent": "cognitive:insistent", "modality": "symbolic?tell=state"}


def effect(of, value, half=0.05):
    mean = {"value": value, "low": value - half, "high": value + half, "n": 150, "clusters": 150, "p_value": 0.001}
    return Estimate(quantity="false_report_effect", of=of, **AGENT, **mean, doses={"flip.p": 0.4})


def success(arm, count):
    share = proportion(count, 150)
    numbers = {"value": share.value, "low": share.low, "high": share.high, "count": count, "n": 150}
    return Estimate(quantity="success_in_arm", of=arm, condition=arm, **AGENT, **numbers)


def drawn(says, disturbs, others=()):
    """The ladder and the bars of an agent."""
    parts = {"total": says + disturbs, "content": says, "disturbance": disturbs}
    arms = {"truth": 30, "lie": 30 + round(150 * (says + disturbs)), "retracted": 30 + round(150 * disturbs)}
    rows = [effect(of, value) for of, value in parts.items()]
    rows += [success(arm, count) for arm, count in (arms | dict.fromkeys(others, 60)).items()]
    figure = why(Results.model_construct(rows=rows))
    figure.draw_without_rendering()
    return figure.axes


def test_the_ladder_has_a_rung_for_every_arm_in_order():
    axes, _ = drawn(0.3, 0.1, others=("remark", "withheld"))
    assert [label.get_text() for label in axes.get_yticklabels()] == ["truth", "lie", "retracted", "remark", "withheld"]
    assert [text.get_text() for text in axes.texts] == ["20 %", "60 %", "30 %", "40 %", "40 %"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first is on top


@pytest.mark.parametrize(("says", "disturbs"), [(0.3, 0), (-0.15, 0), (0.4, -0.15), (0, 0)])
def test_bars_are_the_whole_and_its_parts_with_zero_in_the_middle(says, disturbs):
    _, axes = drawn(says, disturbs)
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == pytest.approx([says + disturbs, says, disturbs])
    low, high = axes.get_ylim()
    assert -low == high > max(abs(height) + 0.05 for height in heights) * 0.99


def test_a_study_of_other_conditions_has_no_such_figure():
    assert why(Results.model_construct(rows=[])) is None
