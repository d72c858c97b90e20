"""The stated priors: how many interlocks, which, and how far from the open box."""

from collections import deque
from itertools import product
from math import factorial

import numpy as np
import pytest

from lockprobe.boxes.beliefs.structures import MOST_INTERLOCKS, NEVER, PRIORS, as_mask, interlocks
from lockprobe.foundation.errors import BadValue, UnknownName


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


def test_counts_for_the_papers_box():
    assert {prior: len(interlocks(prior, 4)) for prior in PRIORS} == {
        "chains": 6, "single-parent": 142, "any-literal": 2152,
    }  # fmt: skip


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 5, 6])
def test_a_chain_is_an_order_of_all_joints_that_ends_in_the_target(joints):
    known = interlocks("chains", joints)
    assert len(set(known.needs)) == len(known) == factorial(joints - 1)
    for needs in known.needs:
        order = [0]
        while (need := needs[order[-1]]) is not None:
            assert need[1] == 1
            order.append(need[0])
        assert sorted(order) == list(range(joints))


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


def test_optima_are_those_of_the_notes():
    steps = interlocks("any-literal", 4).distance[:, 0]
    assert np.bincount(steps).tolist() == [0, 1372, 588, 168, 24]


@pytest.mark.parametrize("prior", PRIORS)
def test_masks_are_the_rule(prior):
    known = interlocks(prior, 3)
    for configuration, joint in product(range(8), range(3)):
        allowed = [may_move(needs, configuration, joint) for needs in known.needs]
        assert (
            known.masks[configuration][joint]
            == as_mask(np.array(allowed))
            == sum(1 << s for s, a in enumerate(allowed) if a)
        )
        everywhere = np.full(len(known), configuration)
        assert known.may_move(everywhere)[:, joint].tolist() == allowed


def test_too_many_interlocks_are_refused_with_their_number():
    with pytest.raises(
        BadValue, match=f"prior any-literal over 5 joints: got '59049 interlocks', expected at most {MOST_INTERLOCKS}"
    ):
        interlocks("any-literal", 5)
    with pytest.raises(BadValue, match="prior single-parent over 6 joints: got '46656 interlocks'"):
        interlocks("single-parent", 6)
    assert len(interlocks("chains", 8)) == 5040


def test_an_unknown_prior_is_refused_with_those_that_exist():
    with pytest.raises(
        UnknownName, match="no prior is called 'chain' .did you mean 'chains'.*single-parent, any-literal"
    ):
        interlocks("chain", 4)
