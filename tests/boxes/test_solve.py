"""The laws of the puzzle; what a box takes, against brute force and published figures; what cannot be played."""

import itertools

import numpy as np
import pytest
from boxes.conftest import any_box
from hypothesis import given, settings

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.sketch import interlock_lines
from lockprobe.boxes.solve import difficulty, fault_of, optimum, random_curve


def solves(puzzle, attempts):
    configuration = puzzle.initial
    for joint in attempts:
        configuration, moved = puzzle.attempt(configuration, joint)
        if moved and joint == puzzle.target_index:
            return True
    return False


@settings(max_examples=25)
@given(any_box())
def test_attempts_in_every_configuration(drawn):
    """A joint moves if any clause holds entirely. Nothing else changes, and a second attempt undoes the first."""
    for configuration, joint in itertools.product(itertools.product((False, True), repeat=4), range(4)):
        after, moved = drawn.attempt(configuration, joint)
        assert all(after[other] == configuration[other] for other in range(4) if other != joint)
        assert moved == (after[joint] != configuration[joint])
        assert drawn.attempt(after, joint)[0] == configuration
        state = dict(zip(drawn.names, configuration, strict=True))
        clauses = drawn.interlock.get(drawn.names[joint], ({},))
        expected = any(set(clause.items()) <= set(state.items()) for clause in clauses)
        assert drawn.may_move(configuration, joint) == moved == expected


@pytest.mark.parametrize(
    ("interlock", "reason"),
    [
        ({"a": ({"b": True},), "b": ({"c": True},), "c": ({"a": True},)}, "unsolvable: nothing moves, every joint is locked at the start"),
        ({"a": ({"b": True},), "b": ({"a": True},)}, "unsolvable: no sequence of attempts moves a"),
        (
            {"a": ({"b": True}, {"c": True, "b": False}), "c": ({"b": True},), "b": ({"c": False},)},
            "contradictory: {c = 1, b = 0} of target a holds in no configuration that can be reached",
        ),
        ({}, "too short: solved in 1 of at least 2 steps"),
        ({"a": ({"b": True},)}, None),
    ],
)  # fmt: skip
def test_what_cannot_be_played_is_said_with_the_reason(interlock, reason):
    joints = tuple(Joint(name=name, kind="revolute") for name in "abc")
    drawn = Lockbox(name="x", joints=joints, interlock=interlock, initial=(False,) * 3, target="a")
    assert fault_of(drawn, shortest=2) == reason
    assert (fault_of(drawn) is None) == (reason is None or reason.startswith("too short"))
    if reason and reason.startswith("unsolvable"):
        found = difficulty(drawn)
        assert (found.optimum, found.optimal_plans, found.plans, found.distractors) == (None, 0, (), ())
        assert (found.random_success, found.cycle_success) == (0, 0)


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
@given(any_box())
def test_optimal_plans_are_all_shortest_sequences_that_solve_and_distractors_the_joints_of_none(puzzle):
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


def test_an_interlock_in_words():
    assert interlock_lines(box("common-effect-3")) == [
        "door (target): lever-0 open",
        "lever-0: lever-1 open, or lever-2 open",
        "lever-1: always free",
        "lever-2: always free",
    ]
    assert interlock_lines(box("reset"))[0] == "revolute-left (target): slider-1 open and revolute-right closed"
