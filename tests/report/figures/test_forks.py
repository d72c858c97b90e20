"""The effect by step: a panel for each agent and condition, a line for each arm, its intervals."""

import pytest
from drawn import bars

from lockprobe.report.figures import render
from lockprobe.report.figures.forks import forks
from lockprobe.report.rows import Estimate, Results


def effect(where, arm, value, condition="truth", quantity="success"):
    return Estimate(
        quantity=f"{quantity}_change_by_fork", agent="random", condition=condition,
        of=f"{arm}, {where}, later reports as in the condition", value=value, low=value - 0.1, high=value + 0.1,
        n=20, clusters=20,
    )  # fmt: skip


FOUND = Results.model_construct(
    rows=[
        *(effect(at, arm, at / 50) for at in (4, 8, 12) for arm in ("lie", "lie-truth")),
        effect("onset", "lie", 0.5),
        effect(4, "lie", 2.0, quantity="steps"),
        effect(4, "lie", -0.3, condition="flip?p=0.4"),
    ]
)


def test_every_arm_is_a_line_over_numbered_steps_with_its_intervals():
    axes, other = forks(FOUND).axes
    named = {drawn.get_label(): drawn.lines[0] for drawn in axes.containers}
    assert list(named) == ["lie", "lie-truth"]
    assert list(named["lie"].get_ydata()) == pytest.approx([0.08, 0.16, 0.24])
    assert [round(x) for x in named["lie"].get_xdata()] == [4, 8, 12]
    values = [
        (one.value, one.low, one.high)
        for arm in ("lie", "lie-truth")
        for one in FOUND.rows[:6]
        if one.of.startswith(f"{arm},")
    ]
    assert [bar[1:] for bar in bars(axes)] == [pytest.approx(value) for value in values]
    low, high = axes.get_ylim()
    assert -low == high >= 0.34
    assert other.get_title(loc="left").endswith("flip?p=0.4; n = 20 trials")


def test_without_a_numbered_step_there_is_nothing_to_draw():
    assert forks(Results.model_construct(rows=[effect("onset", "lie", 0.5)])) is None


def test_it_is_drawn_the_same_every_time():
    first, second = (render(forks(FOUND), "svg") for _ in range(2))
    assert first == second
