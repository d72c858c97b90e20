"""The tests over doses: each keeps its error rate in worlds of known truth, also where trials break."""

import math
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from known_truth import WORLDS, simulated
from solved import drawn as drawn_by
from solved import study

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agents import AgentPair
from lockprobe.statistics.differences import any_difference
from lockprobe.statistics.how_soon import looping, steps_over_doses
from lockprobe.statistics.shape import two_lines

STUDIES = 100


def drawn(name, seed=1):
    return simulated(name, generator(seed, name)).ended


def p_values(played, rng):
    """The P value of each question: whether doses change success, steps or first loops, and in one way only."""

    def turning(found, first):
        turns = found.first is not None and first * found.first.z > 0
        return None if found.p_value is None else found.p_value if turns else 1.0

    onset = looping(played)
    return {
        "success": min((one.p_value for one in any_difference(played, rng)), default=None),
        "speed": steps_over_doses(played).p_value,
        "shape": turning(two_lines(played), 1),
        "looping": onset.p_value if onset else None,
        "looping again": turning(two_lines(played, "first loops"), -1),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", WORLDS)
def test_tests_that_we_conclude_from_keep_their_error_rate(name):
    """Where the truth is no, 13 rejections of 100 have a probability below 0.002 at 5 %; where loops trap, most reject."""
    seen, truths = Counter(), WORLDS[name].truths
    for number in range(STUDIES):
        for question, p in p_values(drawn(name, number), generator(number, name, "tests")).items():
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
    wrong, design = [0, 0], {"p": (0.0, 0.2, 0.4), "trials": 40}
    for number in range(10):
        played = simulated("broken-trials", generator(number), **design, success=(0.5,) * 3, trap=(0.0,) * 3)
        tested = any_difference(played, generator(number))
        wrong[0] += any(one.p_value < 0.05 for one in tested)
        lines = two_lines(played)
        wrong[1] += lines.direction is not None
        for one in tested:
            assert one.low <= one.bounds[0] <= one.bounds[1] <= one.high
    assert max(wrong) <= 2


@pytest.mark.parametrize(("first", "second"), [((0.2,) * 3, (0.9,) * 3), ((0.1, 0.3, 0.5), (0.4, 0.6, 0.8))])
def test_equal_effects_of_noise_on_unequal_agents_are_rarely_taken_for_different_ones(first, second):
    """So few rejections of 100, or fewer, come of a level of 5 % in 999 of 1000 cases."""
    wrong, doses = 0, (0.0, 0.2, 0.4)
    for seed in range(STUDIES):
        both = (drawn_by(np.random.default_rng([seed, i]), of, (3, 1, 30)) for i, of in enumerate((first, second)))
        one, two = (SimpleNamespace(outcomes=study(solved, doses)) for solved in both)
        pair = AgentPair(first=one, second=two, baseline=False, doses=doses)
        wrong += min(found.p_value for found in pair.changes.values()) < 0.05
    assert wrong <= 12


@pytest.mark.parametrize("p", [(0.0, 1e-6, 1.0), (0.0, 1e-6, 2e-6, 1.0), (0.0, 0.5, 0.500001), (-0.1, 0.0, 3.0)])
def test_doses_may_be_close_together_or_negative(p):
    played = simulated("no-effect", generator(3), p=p, success=(0.5,) * len(p), trap=(0.0,) * len(p))
    assert all(one is None or math.isfinite(one) for one in p_values(played, generator(1)).values())
