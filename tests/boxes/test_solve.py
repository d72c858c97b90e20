"""What a box takes, against brute force, definitions, and the published figures of the default box."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.sketch import interlock_lines
from lockprobe.boxes.solve import difficulty, optimum, random_curve


def solves(puzzle, attempts):
    configuration = puzzle.initial
    for joint in attempts:
        configuration, moved = puzzle.attempt(configuration, joint)
        if moved and joint == puzzle.target_index:
            return True
    return False


@pytest.mark.parametrize("joints", [2, 3])
@pytest.mark.parametrize("budget", [1, 3, 5])
def test_random_success_is_the_share_of_all_sequences(joints, budget):
    puzzle = box(f"chain-{joints}")
    sequences = list(itertools.product(range(joints), repeat=budget))
    apart = [s for s in sequences if all(a != b for a, b in itertools.pairwise(s))]
    assert random_curve(puzzle, budget)[-1] == pytest.approx(np.mean([solves(puzzle, s) for s in sequences]))
    assert random_curve(puzzle, budget, repeats=False)[-1] == pytest.approx(np.mean([solves(puzzle, s) for s in apart]))


def test_published_figures_of_chain_4():
    found = difficulty(box("chain-4"))
    assert found.random_success == random_curve(box("chain-4"))[-1] == pytest.approx(0.392655, abs=1e-6)
    assert found.random_no_repeat_success == pytest.approx(0.6893, abs=1e-4)
    assert (found.cycle_success, difficulty(box("fork")).cycle_success) == (1, pytest.approx(2 / 3))


@settings(max_examples=40)
@given(st.data())
def test_optimal_plans_are_all_shortest_sequences_that_solve_and_distractors_the_joints_of_none(boxes, data):
    puzzle = data.draw(boxes)
    found, steps = difficulty(puzzle, None), optimum(puzzle)
    assert (found.optimum, found.optimal_plans) == (steps, len(found.plans))
    moved = {name for plan in found.plans for name in plan}
    assert found.distractors == (tuple(name for name in puzzle.names if name not in moved) if moved else ())
    assert difficulty(puzzle, 1).plans == found.plans[:1]
    order = [tuple(map(puzzle.names.index, plan)) for plan in found.plans]
    assert order == sorted(order)
    if steps is None or steps > 6:
        assert (steps is None) == (not order)
        assert all(len(plan) == steps for plan in order)
    else:
        assert set(order) == {one for one in itertools.product(range(4), repeat=steps) if solves(puzzle, one)}


def test_a_box_that_nothing_opens():
    joints = tuple(Joint(name=name, kind="revolute") for name in "abc")
    interlock = {"a": ({"b": True},), "b": ({"a": True},)}
    shut = Lockbox(name="x", joints=joints, interlock=interlock, initial=(False,) * 3, target="a")
    found = difficulty(shut)
    assert (found.optimum, found.optimal_plans, found.random_success, found.cycle_success) == (None, 0, 0, 0)


def test_an_interlock_in_words():
    assert interlock_lines(box("common-effect-3")) == [
        "door (target): lever-0 open",
        "lever-0: lever-1 open, or lever-2 open",
        "lever-1: always free",
        "lever-2: always free",
    ]
    assert interlock_lines(box("reset"))[0] == "revolute-left (target): slider-1 open and revolute-right closed"
