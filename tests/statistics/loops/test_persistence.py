"""Whether loops are left and blocked joints tried again: counted by hand, and at chance for an agent at random."""

from dataclasses import replace

import numpy as np
import pytest
from builders import make_trial

from lockprobe.statistics.loops.persistence import escapes, loop_left, persistence, repeats

BLOCKED = (0, 1, 2)
"""Joints of chain-4 that are blocked at the start."""


@pytest.mark.parametrize(
    ("joints", "left"),
    [
        ([0, 1, 2] * 5, False),
        ([0, 1, 2] * 2 + [0, 1, 1, 0], True),
        ([0, 1, 2] * 2 + [1], True),
        ([0, 1, 2, 1] * 3, False),
        ([0, 0, 0] * 4, False),
        ([0, 1, 2] * 2, None),
        ([0, 1, 2, 2, 1, 0], None),
    ],
    ids=["goes on", "left late", "left at once", "cycle of four", "one joint", "ends with the loop", "no loop"],
)
def test_a_loop_is_left_by_the_first_action_that_it_has_not(joints, left):
    found = loop_left(make_trial(joints))
    assert (found and found[0]) == left if left is not None else found is None


def test_chance_leaves_a_loop_the_sooner_the_more_steps_there_are():
    assert loop_left(make_trial([0, 1, 2] * 2 + [0]))[1] == pytest.approx(3 / 4)
    assert loop_left(make_trial([0, 1, 2] * 2 + [0, 1]))[1] == pytest.approx(15 / 16)


def test_repeats_are_counted_from_the_last_report_of_a_move():
    assert repeats(make_trial([0, 0, 1, 0])) == [(True, 0.25, 0), (False, 0.25, 0), (True, 0.5, 1 / 3)]
    assert repeats(make_trial([0, 3, 0, 1])) == [(False, 0.25, 0), (False, 0.25, 0)]  # 3 moves: all are new again
    assert repeats(make_trial([0, 0, 0], false_at=[1])) == [(True, 0.25, 0)]  # what was told counts, not the truth


def test_where_no_alternative_is_left_nothing_is_repeated():
    assert repeats(make_trial([0, 1, 2, 3, 0, 0], false_at=[4]))[3:] == []


def test_an_action_leaves_a_loop_where_it_is_not_the_one_that_followed():
    assert escapes(make_trial([0, 1, 2, 0, 1, 2])) == []
    assert escapes(make_trial([0, 1, 2, 0, 1, 2, 0, 1, 1])) == [
        (False, 0.75, pytest.approx(2 / 3)), (False, 0.75, pytest.approx(2 / 3)), (True, 0.75, pytest.approx(2 / 3)),
    ]  # fmt: skip
    assert escapes(make_trial([0] * 8)) == [(False, 0.75, 1.0)] * 2  # without repeats it could not stay
    assert escapes(make_trial([2, 1, 0, 0, 2, 1, 0, 3, 0, 2, 1])) == [(True, 0.75, 1.0)]


def test_shares_stand_beside_chance():
    found = persistence([make_trial([0, 1, 2] * 4 + [0] * (i % 3), trial=i) for i in range(1, 10)])
    assert (found.left.count, found.left.n, found.left.clusters) == (3, 9, 9)  # those that end AA
    assert found.left_by_chance > 0.99
    assert (found.escaped.share.count, found.escaped.share.n) == (3, 9 * 6 + 9)
    assert (found.escaped.uniform, found.escaped.direction, found.escaped.p_value < 0.05) == (0.75, -1, True)
    assert found.repeated.share.n == 9 * 11 + 9
    assert (found.repeated.direction, found.repeated.p_value < 0.05) == (1, True)
    broken = persistence([make_trial([0] * 20, broken="model")])
    assert (broken.left.n, broken.left_by_chance) == (0, None)
    for kind in (broken.escaped, broken.repeated):
        assert (kind.share.n, kind.uniform, kind.no_repeat, kind.p_value) == (0, None, None, None)


def test_trials_that_are_all_alike_are_certain_but_not_beyond_coins():
    found = persistence([make_trial([0] * 20, trial=i) for i in range(1, 9)])
    assert (found.repeated.share.value, found.repeated.p_value) == (1.0, 2.0**-7)
    assert (found.escaped.share.value, found.escaped.p_value) == (0.0, 2.0**-7)
    assert persistence([make_trial([0] * 20, trial=i) for i in range(1, 7)]).repeated.p_value is None


def at_random(rng, *, repeats):
    """Twenty blocked or moving attempts, uniformly random, or so without immediate repeats."""
    steps = rng.integers(0, 4, 20) if repeats else (rng.integers(0, 4) + np.cumsum(rng.integers(1, 4, 20))) % 4
    return steps.tolist()


@pytest.mark.parametrize("uniform", [True, False])
def test_an_agent_at_random_is_at_its_chance(uniform):
    rng = np.random.default_rng(1)
    studies = [
        persistence([make_trial(at_random(rng, repeats=uniform), trial=i) for i in range(1, 31)]) for _ in range(60)
    ]
    for kind in ("escaped", "repeated"):
        found = [getattr(study, kind) for study in studies]
        assert sum(one.p_value < 0.05 for one in found) <= 8  # 3 standard errors above 5 %
        chance = np.mean([one.uniform if uniform else one.no_repeat for one in found])
        assert np.mean([one.share.value for one in found]) == pytest.approx(chance, abs=0.02)
    if uniform:
        left, chance = (np.mean([one.left.value for one in studies]), np.mean([one.left_by_chance for one in studies]))
        assert left == pytest.approx(chance, abs=0.01)


def test_between_the_two_chances_nothing_is_shown():
    """Actions are repeated less often than uniform ones, as by an agent without immediate repeats."""
    rng = np.random.default_rng(2)
    found = persistence([make_trial(at_random(rng, repeats=False), trial=i) for i in range(1, 301)]).repeated
    assert found.share.value < found.uniform - 0.1
    assert found.p_value > 0.05


def test_trials_of_one_person_are_one_cluster():
    trials = [make_trial([0] * 20, agent="participant", trial=i) for i in range(1, 9)]
    people = [replace(trial, agent=f"participant:{i // 2}") for i, trial in enumerate(trials)]
    assert persistence(people).repeated.share.clusters == 4
