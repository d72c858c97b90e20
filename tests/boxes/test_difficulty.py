"""Every measure against its definition."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import (
    depths,
    difficulty,
    optimal_plans,
    optimum,
    random_curve,
    random_success,
)

FOUR = ("chain-4", "bichain-4", "fork", "converge", "reset", "gray-code", "common-cause-3", "common-effect-3")


def replayed(drawn, plan):
    """Configurations before each attempt of a plan, and after the last."""
    path = [drawn.initial]
    for name in plan:
        after, moved = drawn.attempt(path[-1], drawn.names.index(name))
        assert moved
        path.append(after)
    return path


@settings(max_examples=30)
@given(st.data())
def test_undone_moves_and_distractors_are_those_of_the_plans(boxes, data):
    drawn = data.draw(boxes)
    found, plans = difficulty(drawn), optimal_plans(drawn, limit=None)
    assert found.optimal_plans == plans.count == len(plans.listed)
    if not plans.listed:
        assert (found.optimum, found.undone, found.distractors) == (None, None, ())
        return
    back = []
    for plan in plans.listed:
        path = replayed(drawn, plan)
        returns = [path[i + 1][j] == drawn.initial[j] for i, j in enumerate(map(drawn.names.index, plan))]
        back.append(sum(returns))
    assert found.undone == min(back)
    moved = {name for plan in plans.listed for name in plan}
    assert found.distractors == tuple(name for name in drawn.names if name not in moved)
    assert found.optimum == len(plans.listed[0])


@settings(max_examples=30)
@given(st.data())
def test_depth_never_exceeds_the_optimum(boxes, data):
    drawn = data.draw(boxes)
    found = difficulty(drawn)
    if found.optimum is not None:
        assert 1 <= found.depth <= found.optimum
    assert sum(layer == 1 for layer in depths(drawn).values()) == found.free


@pytest.mark.parametrize("name", FOUR)
def test_expected_steps_are_the_area_above_the_curve(name):
    """The mean of a waiting time is the sum of what is left, over all steps."""
    expected = difficulty(box(name)).random_steps
    left = 1 - np.array(random_curve(box(name), round(40 * expected)))
    assert left[-1] < 1e-12
    assert expected == pytest.approx(left.sum(), rel=1e-9)


def test_measures_of_the_boxes_that_tell_them_apart():
    chain, fork, reset = (difficulty(box(name)) for name in ("chain-4", "fork", "reset"))
    assert (chain.depth, chain.undone, chain.optimal_plans, chain.cycle_success) == (4, 0, 1, 1)
    assert (fork.depth, fork.optimal_plans, fork.distractors, fork.free) == (2, 2, ("revolute-right",), 3)
    assert (reset.depth, reset.optimum, reset.undone, reset.optimal_plans) == (4, 5, 1, 2)
    assert difficulty(box("gray-code")).undone == 3


def test_a_box_that_nothing_opens():
    joints = tuple(Joint(name=name, kind="revolute") for name in "abc")
    interlock = {"a": ({"b": True},), "b": ({"a": True},)}
    shut = Lockbox(name="x", joints=joints, interlock=interlock, initial=(False,) * 3, target="a")
    found = difficulty(shut)
    assert (optimum(shut), random_success(shut)) == (None, 0)
    assert (found.optimum, found.optimal_plans, found.depth, found.random_blocked) == (None, 0, None, None)
    assert found.random_steps == inf
    assert found.reachable == 2
    assert found.cycle_success == 0
