"""Every measure against its definition."""

from math import inf

from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import (
    difficulty,
    optimal_plans,
    optimum,
    random_success,
)


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
