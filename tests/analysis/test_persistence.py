"""Whether loops are left and blocked joints tried again: counted by hand, and at chance for an agent at random."""

from dataclasses import replace

import numpy as np
import pytest
from builders import make_trial

from lockprobe.analysis.persistence import loop_left, persistence, repeats

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
    assert repeats(make_trial([0, 0, 1, 0])) == [(True, 0.25), (False, 0.25), (True, 0.5)]
    assert repeats(make_trial([0, 3, 0, 1])) == [(False, 0.25), (False, 0.25)]  # 3 moves: all are new again
    assert repeats(make_trial([0, 0, 0], false_at=[1])) == [(True, 0.25)]  # what was told counts, not the truth


def test_where_no_alternative_is_left_nothing_is_repeated():
    assert repeats(make_trial([0, 1, 2, 3, 0, 0], false_at=[4]))[3:] == []


def test_shares_stand_beside_chance():
    found = persistence([make_trial([0, 1, 2] * 4 + [0] * (i % 3), trial=i) for i in range(1, 10)])
    assert (found.left.count, found.left.n, found.left.clusters) == (3, 9, 9)  # those that end AA
    assert found.left_by_chance > 0.99
    assert found.repeated.n == 9 * 11 + 9
    assert (found.repeated_direction, found.repeated_p_value < 0.05) == (1, True)
    broken = persistence([make_trial([0] * 20, broken="model")])
    assert (broken.left.n, broken.repeated.n, broken.left_by_chance, broken.repeated_p_value) == (0, 0, None, None)


def test_trials_that_are_all_alike_are_certain_but_not_beyond_coins():
    found = persistence([make_trial([0] * 20, trial=i) for i in range(1, 9)])
    assert (found.repeated.value, found.repeated_p_value) == (1.0, 2.0**-7)
    assert persistence([make_trial([0] * 20, trial=i) for i in range(1, 7)]).repeated_p_value is None


def test_an_agent_at_random_repeats_as_often_as_chance():
    rng = np.random.default_rng(1)
    studies = [
        persistence([make_trial(rng.integers(0, 4, 20).tolist(), trial=i) for i in range(1, 31)]) for _ in range(70)
    ]
    assert sum(found.repeated_p_value < 0.05 for found in studies) <= 9  # 3 standard errors above 5 %
    pooled = [np.mean([getattr(f, name) for f in studies]) for name in ("repeated_by_chance", "left_by_chance")]
    assert np.mean([f.repeated.value for f in studies]) == pytest.approx(pooled[0], abs=0.01)
    assert np.mean([f.left.value for f in studies]) == pytest.approx(pooled[1], abs=0.01)


def test_trials_of_one_person_are_one_cluster():
    trials = [make_trial([0] * 20, agent="participant", trial=i) for i in range(1, 9)]
    people = [replace(trial, agent=f"participant:{i // 2}") for i, trial in enumerate(trials)]
    assert persistence(people).repeated.clusters == 4
