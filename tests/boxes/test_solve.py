"""The solver against brute force, and the published figures of the default box."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimal_plans, optimum, random_curve, random_no_repeat_success, random_success


def solves(puzzle, attempts):
    configuration = puzzle.initial
    for joint in attempts:
        configuration, moved = puzzle.attempt(configuration, joint)
        if moved and joint == puzzle.target_index:
            return True
    return False


@pytest.mark.parametrize("budget", [1, 3, 5])
def test_random_success_is_the_share_of_all_sequences(budget):
    puzzle = box("chain-3")
    sequences = list(itertools.product(range(3), repeat=budget))
    apart = [s for s in sequences if all(a != b for a, b in itertools.pairwise(s))]
    assert random_success(puzzle, budget) == pytest.approx(np.mean([solves(puzzle, s) for s in sequences]))
    assert random_no_repeat_success(puzzle, budget) == pytest.approx(np.mean([solves(puzzle, s) for s in apart]))


def test_published_figures_of_chain_4():
    assert random_success(box("chain-4")) == pytest.approx(0.392655, abs=1e-6)
    assert random_no_repeat_success(box("chain-4")) == pytest.approx(0.6893, abs=1e-4)
    assert random_curve(box("chain-4"))[-1] == random_success(box("chain-4"))


@settings(max_examples=30)
@given(st.data())
def test_optimum_is_that_of_growing_sets(boxes, brute_optimum, data):
    puzzle = data.draw(boxes)
    assert optimum(puzzle) == brute_optimum(puzzle)


@settings(max_examples=30)
@given(st.data())
def test_optimal_plans_are_all_shortest_sequences_that_solve(boxes, data):
    puzzle = data.draw(boxes)
    steps = optimum(puzzle)
    plans = optimal_plans(puzzle)
    if steps is None or steps > 6:
        assert plans.count >= (steps is not None)
        assert all(len(plan) == steps for plan in plans.listed)
        return
    solving = {
        tuple(puzzle.names[j] for j in attempts)
        for attempts in itertools.product(range(4), repeat=steps)
        if solves(puzzle, attempts)
    }
    assert set(plans.listed) == solving
    assert plans.count == len(plans.listed) == len(solving)
    order = [tuple(map(puzzle.names.index, plan)) for plan in plans.listed]
    assert order == sorted(order)
