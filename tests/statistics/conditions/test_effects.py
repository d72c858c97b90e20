"""Differences of conditions from the control, on agents whose rule is known."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.conditions.effects import effects
from lockprobe.statistics.conditions.series import Crossing


def trials(solved):
    """One trial for each entry: solved or not."""
    return [make_trial(SOLUTION if one else [0] * 20, trial=i, budget=20) for i, one in enumerate(solved, 1)]


def test_a_condition_that_solves_every_trial_is_told_apart_and_one_that_plays_alike_is_not():
    truth = [False] * 30
    found = effects({"truth": trials(truth), "all": trials([True] * 30), "same": trials(truth)}, "truth")
    every, same = found.effects
    assert (every.condition, every.difference.value, every.detectable) == ("all", 1.0, True)
    assert (same.condition, same.difference.value, same.detectable) == ("same", 0.0, False)


def test_a_crossing_is_the_difference_of_differences():
    rng = np.random.default_rng(1)
    neither, first, second, both = (rng.random((4, 60)) < np.array([[0.1], [0.1], [0.1], [0.9]])).tolist()
    crossing = Crossing(neither="o", first="a", second="b", both="ab")
    found = effects(
        {"o": trials(neither), "a": trials(first), "b": trials(second), "ab": trials(both)}, "o", [crossing]
    )
    (one,) = found.interplays
    expected = np.mean(both) - np.mean(first) - np.mean(second) + np.mean(neither)
    assert one.change.value == pytest.approx(expected)
    assert one.detectable


def test_conditions_without_a_trial_in_common_with_the_control_have_no_effects():
    broken = [make_trial([0], trial=1, broken="model")]
    assert effects({"truth": trials([True]), "a": broken}, "truth") is None
    assert effects({"truth": broken, "a": trials([True])}, "truth") is None


def crossings_of(names):
    """All crossings of interventions that are played alone and in pairs."""
    return [
        Crossing(neither="o", first=one, second=other, both=one + other)
        for i, one in enumerate(names)
        for other in names[i + 1 :]
    ]


def test_interactions_are_corrected_for_their_number_and_for_the_agents():
    rng = np.random.default_rng(3)
    names = ["o", *"abcd", *(one.both for one in crossings_of("abcd"))]
    played = {name: trials((rng.random(40) < 0.5).tolist()) for name in names}
    six, ten = (effects(played, "o", crossings_of("abcd"), agents=agents) for agents in (1, 10))
    alone = [effects(played, "o", [one]).interplays[0] for one in crossings_of("abcd")]
    for one, of_six, of_sixty in zip(alone, six.interplays, ten.interplays, strict=True):
        assert (one.choices, of_six.choices, of_sixty.choices) == (1, 6, 60)
        assert one.change.value == of_six.change.value
        assert of_six.change.p_value == pytest.approx(min(1, 6 * one.change.p_value))
        assert of_sixty.change.low <= of_six.change.low < one.change.low


def test_of_six_crossings_that_change_nothing_none_is_seldom_said_to():
    """40 studies; uncorrected, one of six is found in every sixth."""
    rng = np.random.default_rng(1)
    names = ["o", *"abcd", *(one.both for one in crossings_of("abcd"))]
    said = 0
    for _ in range(40):
        played = {name: trials((rng.random(20) < 0.5).tolist()) for name in names}
        said += any(one.detectable for one in effects(played, "o", crossings_of("abcd")).interplays)
    assert said <= 5


def test_differences_are_corrected_for_the_agents_and_an_interval_says_what_the_test_says():
    truth = [False] * 20 + [True] * 10
    played = {"truth": trials(truth), "better": trials([False] * 11 + [True] * 19)}
    alone, of_ten = (effects(played, "truth", agents=agents).effects[0] for agents in (1, 10))
    assert alone.detectable
    assert of_ten.difference.p_value > alone.difference.p_value
    for one in (alone, of_ten):
        assert one.detectable == (one.difference.low > 0)
    assert of_ten.difference.low < alone.difference.low
