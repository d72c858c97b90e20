"""The solver against brute force, and the published figures of the default box."""

import itertools

import numpy as np
import pytest

from lockprobe.lockbox.box import Joint, Lockbox
from lockprobe.lockbox.families import box
from lockprobe.lockbox.solve import optimum, random_no_repeat_success, random_success


def solves(puzzle, attempts):
    configuration = puzzle.initial
    for joint in attempts:
        configuration, moved = puzzle.attempt(configuration, joint)
        if moved and joint == puzzle.target_index:
            return True
    return False


@pytest.mark.parametrize("size", [2, 3, 4])
def test_optimum_is_the_shortest_solving_sequence(size):
    puzzle = box(f"chain-{size}")
    shortest = next(
        length
        for length in itertools.count(1)
        if any(solves(puzzle, attempts) for attempts in itertools.product(range(size), repeat=length))
    )
    assert optimum(puzzle) == shortest == size


def test_a_box_that_nothing_opens_has_no_optimum():
    joints = (Joint(name="a", kind="revolute"), Joint(name="b", kind="revolute"))
    puzzle = Lockbox(
        name="x",
        joints=joints,
        interlock={"a": ({"b": True},), "b": ({"a": True},)},
        initial=(False, False),
        target="a",
    )
    assert optimum(puzzle) is None
    assert random_success(puzzle) == 0


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


def test_every_cycle_of_the_four_joints_opens_chain_4():
    """Looping is not failing: all 24 fixed cycles solve the box within the paper's budget."""
    assert all(solves(box("chain-4"), cycle * 5) for cycle in itertools.permutations(range(4)))
