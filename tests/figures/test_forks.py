"""The effect by step: a panel for each agent and condition, a line for each arm, its intervals."""

import pytest
from matplotlib.figure import Figure

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.branch import BranchEffect
from lockprobe.figures import fork_drawing, fork_panels, render
from lockprobe.figures.forks import draw_forks


def effect(where, arm, value, condition="truth", outcome="solved"):
    change = BlockMean(value=value, low=value - 0.1, high=value + 0.1, p_value=0.5, pairs=20, blocks=20)
    about = {"agent": "random", "condition": condition, "where": where, "arm": arm, "truthful": False}
    return BranchEffect(**about, outcome=outcome, after_truth=0.5, change=change, forks=20)


FOUND = [
    *(effect(str(at), arm, at / 50) for at in (4, 8, 12) for arm in ("lie", "retracted")),
    effect("onset", "lie", 0.5),
    effect("4", "lie", 2.0, outcome="steps"),
    effect("4", "lie", -0.3, condition="flip?p=0.4"),
]


def test_panels_hold_success_at_numbered_steps_alone():
    first, second = fork_panels(FOUND)
    assert [(one.where, one.arm) for one in first] == [
        (str(at), arm) for at in (4, 8, 12) for arm in ("lie", "retracted")
    ]
    assert [one.condition for one in second] == ["flip?p=0.4"]


def test_every_arm_is_a_line_over_the_steps_with_its_intervals():
    axes = Figure().subplots()
    draw_forks(axes, fork_panels(FOUND)[0])
    named = {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}
    assert list(named) == ["lie", "retracted"]
    assert list(named["lie"].get_ydata()) == pytest.approx([0.08, 0.16, 0.24])
    assert [round(x) for x in named["lie"].get_xdata()] == [4, 8, 12]
    bars = [line for line in axes.lines if len(line.get_xdata()) == 2 and line.get_xdata()[0] == line.get_xdata()[1]]
    assert len(bars) == 6
    low, high = axes.get_ylim()
    assert -low == high >= 0.34


def test_it_is_drawn_the_same_every_time():
    first, second = (render(fork_drawing(FOUND), "svg") for _ in range(2))
    assert first == second
