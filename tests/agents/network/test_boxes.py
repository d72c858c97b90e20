"""Boxes to train on: distances and best joints are those of the project's own search, chances are as stated."""

import numpy as np
import pytest

from lockprobe.agents.network.boxes import BEFORE, LOCKED, OPEN, copies, random_boxes
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimal_plans, optimum


@pytest.mark.parametrize("name", ["chain-4", "bichain-4", "random-5-17"])
def test_copies_of_a_box_are_solved_by_its_optimal_plans_and_by_nothing_shorter(name):
    known = box(name)
    made = copies(known, 40, np.random.default_rng(1))
    start = np.zeros(40, dtype=np.int64)
    assert set(made.distance[np.arange(40), start]) == {optimum(known)}
    firsts = {plan[0] for plan in optimal_plans(known).listed}
    assert set(made.best(start).sum(axis=1)) == {len(firsts)}
    state = start
    for left in range(optimum(known), 0, -1):
        assert (made.distance[np.arange(40), state] == left).all()
        joint = made.best(state).argmax(axis=1)
        assert made.moves(state)[np.arange(40), joint].all()
        assert ((joint == made.target) == (left == 1)).all()
        state = state ^ (1 << joint)


def test_joints_of_copies_are_dealt_evenly():
    targets = np.bincount(copies(box("chain-4"), 4000, np.random.default_rng(2)).target)
    assert abs(targets - 1000).max() < 4 * (4000 * 0.25 * 0.75) ** 0.5


def test_random_boxes_have_the_stated_chances():
    number = 20_000
    made = random_boxes(number, 4, np.random.default_rng(3))
    every, start = np.arange(number), np.zeros(number, dtype=np.int64)
    assert not made.moves(start)[every, made.target].any()
    assert (made.distance[every, start] < 10).all()
    # the target needs the joint before it, or any of the three: then two steps do where that one is free at once
    free = made.moves(start).sum(axis=1)
    stuck = LOCKED * OPEN  # of each of two joints; the first is always free, the target never
    assert np.mean(free) == pytest.approx(1 + 2 * (1 - stuck), abs=4 * 0.7 / number**0.5)
    two = np.mean(made.distance[every, start] == 2)
    earlier = (1 - BEFORE) / 3
    chance = (BEFORE + earlier) * (1 - stuck) + earlier * (1 - stuck) + earlier
    assert two == pytest.approx(chance, abs=4 * 0.5 / number**0.5)
