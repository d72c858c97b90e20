"""The pictures of rationality are the numbers of the summary."""

import numpy as np
import pytest
from drawn import bars

from lockprobe import figures


def reads(found, name):
    share = getattr(found, name)
    return (share.value, share.low, share.high)


@pytest.mark.parametrize(
    ("draw", "name"),
    [(figures.draw_optimal_actions, "optimal"), (figures.draw_steps_lost, "regret")],
)
def test_both_observers_stand_with_their_intervals_beside_chance(axes, typical, draw, name):
    agent = typical.agents[-1]
    draw(axes, agent)
    expected = [reads(condition.rationality[i], name) for i in (0, 1) for condition in agent.conditions]
    assert np.allclose([bar[1:] for bar in bars(axes)], expected)
    played = [condition.p for condition in agent.conditions]
    assert np.allclose([bar[0] for bar in bars(axes)], played * 2, atol=0.01)
    chance = {
        line.get_linestyle(): list(line.get_ydata()) for line in axes.lines if line.get_linestyle() in {":", "--"}
    }
    for i, dash in enumerate((":", "--")):
        assert chance[dash] == [condition.rationality[i].by_chance[name] for condition in agent.conditions]


def test_everything_is_in_sight(axes, studies):
    for agent in studies["strategies"].agents:
        figures.draw_steps_lost(axes, agent)
        low, high = axes.get_ylim()
        assert low < 0
        assert all(
            condition.rationality[i].by_chance["regret"] < high for condition in agent.conditions for i in (0, 1)
        )
        axes.clear()


def test_the_number_of_actions_is_said(axes, typical):
    agent = typical.agents[-1]
    figures.draw_optimal_actions(axes, agent)
    sizes = [condition.rationality[0].steps for condition in agent.conditions]
    assert f"n = {min(sizes)} to {max(sizes)} actions per flip rate" in axes.get_title(loc="left")


def test_chance_can_be_seen_at_a_single_p(axes, studies):
    figures.draw_optimal_actions(axes, studies["one p"].agents[-1])
    (line,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    low, high = line.get_xdata()
    assert low < 0 < high


def test_there_is_no_picture_of_what_was_not_judged(studies):
    assert "rationality" in figures.pictures(studies["one trial"])
    assert "rationality" not in figures.pictures(studies["errors"])
