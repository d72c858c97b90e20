"""The tests over doses: each keeps its error rate in worlds of known truth, also where trials break."""

import math

import numpy as np
import pytest
from known_truth import WORLDS, Design, simulated
from solved import columns

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.power.effects import BUDGET
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.over_doses import (
    TESTS,
    p_values,
    possible_ends,
    rise_and_fall,
    success_by_dose,
)
from lockprobe.statistics.outcomes import outcomes

STUDIES = 100


def drawn(name, seed=1, design=None):
    return simulated(name, generator(seed, name), design)[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", WORLDS)
def test_tests_that_we_conclude_from_keep_their_error_rate(name):
    """Where the truth is no, 13 rejections of 100 have a probability below 0.002 at 5 %; where loops trap, most reject."""
    seen, truths = dict.fromkeys(TESTS, 0), WORLDS[name].truths
    for number in range(STUDIES):
        found = p_values(drawn(name, number), generator(number, name, "tests"), BUDGET)
        assert found.keys() == TESTS.keys()
        for question, p in found.items():
            assert p is None or 0 <= p <= 1
            seen[question] += p is not None and p < 0.05
    assert {question: k for question, k in seen.items() if question not in truths and k > 12} == {}
    if name == "loop-trapped":
        assert seen["looping"] > 60


@pytest.mark.slow
@pytest.mark.parametrize("name", ["no-effect", "unequal-luck", "saturating", "inverted-u"])
def test_no_interval_of_the_differences_leaves_out_the_truth(name):
    """Of all six differences of a study together: in at most 5 % of studies, and of 100 in at most 12."""
    truth, missed = WORLDS[name].success, 0
    for number in range(STUDIES):
        found = any_difference(drawn(name, number), generator(number), 99)
        missed += any(not one.low <= t - truth[0] <= one.high for one, t in zip(found, truth[1:], strict=True))
    assert missed <= 12


def test_broken_trials_find_no_effect_that_is_not_there():
    """Failures break at the highest dose alone: of those that remain most are solved.

    Where the broken ones are left out, half of these studies find an effect.
    """
    wrong, design = [0, 0], Design(p=(0.0, 0.2, 0.4), trials=40)
    for number in range(10):
        ended, broken = simulated("broken-trials", generator(number), design, success=(0.5,) * 3, trap=(0.0,) * 3)
        tested = success_by_dose(ended, broken, generator(number), BUDGET)
        wrong[0] += any(one.p_value < 0.05 for one in tested)
        lines = rise_and_fall(ended, broken, BUDGET)
        wrong[1] += lines.direction is not None
        for one in tested:
            assert one.low <= one.bounds[0] <= one.bounds[1] <= one.high
    assert max(wrong) <= 2


@pytest.mark.parametrize("shape", [False, True])
def test_every_end_completes_every_trial_that_broke(shape):
    ended, broken = simulated("broken-trials", generator(3))
    ends = possible_ends(ended, broken, BUDGET, shape=shape)
    assert [len(end) for end in ends] == [len(ended) + len(broken)] * (4 if shape else 2)
    solved = [end.solved[len(ended) :] for end in ends]
    assert all((one ^ other).all() for one, other in zip(solved[::2], solved[1::2], strict=True))
    assert possible_ends(ended, broken.at(broken.dose < 0), BUDGET) == []


def test_a_clear_peak_is_found_even_if_one_side_is_all_or_nothing():
    p = np.repeat([0.0, 0.1, 0.2, 0.3, 0.4], 30)
    solved = np.concatenate([np.arange(30) < k for k in (0, 0, 30, 4, 0)])
    played = columns(p, np.tile(np.arange(30) + 1, 5), length=9, solved=solved)
    assert p_values(played, generator(1), BUDGET)["shape"] < 0.05


@pytest.mark.parametrize("trials", ["none", "one p", "one trial"])
def test_too_little_to_test_gives_no_p_value(trials):
    played = outcomes([]) if trials == "none" else drawn("no-effect")
    if trials == "one p":
        played = played.at(played.dose == 0)
    if trials == "one trial":
        played = played.at(np.arange(len(played)) == 0)
    found = p_values(played, generator(1), BUDGET)
    assert {found[question] for question in ("success", "shape", "looping")} == {None}


@pytest.mark.parametrize("p", [(0.0, 1e-6, 1.0), (0.0, 1e-6, 2e-6, 1.0), (0.0, 0.5, 0.500001), (-0.1, 0.0, 3.0)])
def test_doses_may_be_close_together_or_negative(p):
    played, _ = simulated("no-effect", generator(3), Design(p=p), success=(0.5,) * len(p), trap=(0.0,) * len(p))
    assert all(one is None or math.isfinite(one) for one in p_values(played, generator(1), BUDGET).values())
