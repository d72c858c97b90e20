"""The stated priors: how many interlocks, which, and how far from the open box."""

from collections import deque
from itertools import product

import pytest

from lockprobe.boxes.beliefs.structures import MOST_INTERLOCKS, NEVER, PRIORS, interlocks
from lockprobe.foundation.errors import BadValue


def may_move(needs, configuration, joint):
    need = needs[joint]
    return need is None or (configuration >> need[0] & 1) == need[1]


def distance(needs, start):
    """Breadth-first search, one interlock at a time."""
    queue, seen = deque([(start, 1)]), {start}
    while queue:
        here, steps = queue.popleft()
        if may_move(needs, here, 0):
            return steps
        for joint in range(1, len(needs)):
            there = here ^ 1 << joint
            if may_move(needs, here, joint) and there not in seen:
                seen.add(there)
                queue.append((there, steps + 1))
    return NEVER


@pytest.mark.parametrize(("prior", "positions"), [("single-parent", [1]), ("any-literal", [0, 1])])
@pytest.mark.parametrize("joints", [2, 3, 4])
def test_literals_are_all_that_can_be_solved(prior, positions, joints):
    choices = [[None, *product(set(range(joints)) - {joint}, positions)] for joint in range(joints)]
    every = set(product(*choices))
    assert set(interlocks(prior, joints).needs) == {needs for needs in every if distance(needs, 0) < NEVER}


@pytest.mark.parametrize("prior", PRIORS)
def test_optima_of_any_literal_and_distances_from_everywhere(prior):
    known = interlocks(prior, 3)
    for needs, found in zip(known.needs, known.distance, strict=True):
        assert found.tolist() == [distance(needs, start) for start in range(8)]


def test_too_many_interlocks_are_refused_with_their_number():
    with pytest.raises(
        BadValue, match=f"prior any-literal over 5 joints: got '59049 interlocks', expected at most {MOST_INTERLOCKS}"
    ):
        interlocks("any-literal", 5)
    with pytest.raises(BadValue, match="prior single-parent over 6 joints: got '46656 interlocks'"):
        interlocks("single-parent", 6)
