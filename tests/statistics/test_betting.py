"""E-processes and confidence sequences by betting: against integrals, enumerations and grids."""

import itertools
import math

import numpy as np
import pytest

from lockprobe.statistics.betting import confidence_sequence, log_wealth

LIMIT = math.log(20)
PAIRS = {"low": -1.0, "high": 1.0}


@pytest.mark.parametrize("mean", [0.0, 0.1, -0.4])
def test_under_the_hypothesis_the_wealth_of_pairs_is_1_in_the_mean_although_how_many_differ_depends_on_the_past(mean):
    def chance(values):
        found = 1.0
        for i, one in enumerate(values):
            differ = abs(mean) + (1 - abs(mean)) * (0.9 if sum(map(abs, values[:i])) % 2 else 0.2)
            found *= {0: 1 - differ, 1: (differ + mean) / 2, -1: (differ - mean) / 2}[one]
        return found

    expected = np.zeros(6)
    for values in itertools.product((-1, 0, 1), repeat=6):
        expected += chance(values) * np.exp(log_wealth(values, mean, **PAIRS))
    assert expected == pytest.approx(np.ones(6))


@pytest.mark.parametrize(("side", "true"), [("below", 0.1), ("below", 0.3), ("above", 0.1), ("above", -0.5)])
def test_on_the_side_of_the_hypothesis_wealth_of_one_sided_bets_is_not_expected_to_grow(side, true):
    chances = {0: 0.4, 1: 0.3 + true / 2, -1: 0.3 - true / 2}
    for past in itertools.product((-1, 0, 1), repeat=4):
        had = log_wealth(past, 0.1, **PAIRS, side=side)[-1]
        then = [math.exp(log_wealth([*past, one], 0.1, **PAIRS, side=side)[-1]) for one in chances]
        expected = float(np.dot([*chances.values()], then))
        assert expected <= math.exp(had) * (1 + 1e-12)
        if true == 0.1:
            assert expected == pytest.approx(math.exp(had))
    away = {0: 0.4, 1: 0.3, -1: 0.3} if side == "below" else {0: 0.4, 1: 0.6, -1: 0.0}
    assert sum(c * math.exp(log_wealth([one], 0.1, **PAIRS, side=side)[-1]) for one, c in away.items()) > 1


@pytest.mark.parametrize("mean", [0.05, 0.5])
def test_twenty_is_ever_exceeded_in_at_most_a_twentieth_of_studies(mean):
    numbers = 300
    solved_at = [log_wealth([1] * k + [0] * (numbers - k), mean)[max(k - 1, 0) :] for k in range(numbers + 1)]
    open_, crossed = np.array([1.0]), 0.0
    for n in range(1, numbers + 1):
        open_ = np.append(open_ * (1 - mean), 0) + np.append(0, open_ * mean)
        wealth = np.array([solved_at[k][n - max(k, 1)] for k in range(n + 1)])
        crossed += open_[wealth >= LIMIT].sum()
        open_[wealth >= LIMIT] = 0
    assert crossed + open_.sum() == pytest.approx(1)
    assert 0.015 < crossed <= 0.05


@pytest.mark.parametrize("seed", range(4))
def test_an_interval_holds_the_means_that_no_look_has_rejected(seed):
    rng = np.random.default_rng(seed)
    values = rng.choice([-1, 0, 1], size=45, p=[0.1, 0.5, 0.4]) if seed % 2 else rng.uniform(-1, 1, 45)
    lows, highs = confidence_sequence(values, LIMIT, **PAIRS)
    grid = np.linspace(-0.995, 0.995, 200)
    kept = np.array([np.maximum.accumulate(log_wealth(values, mean, **PAIRS)) < LIMIT for mean in grid])
    for at in (0, 3, 20, 44):
        held = (grid > lows[at]) & (grid < highs[at])
        assert (held == kept[:, at]).all()


def test_intervals_lie_within_those_before_and_do_not_depend_on_what_comes_later():
    values = np.random.default_rng(5).choice([-1, 0, 1], size=240)
    lows, highs = confidence_sequence(values, LIMIT, **PAIRS)
    assert (np.diff(lows) >= 0).all()
    assert (np.diff(highs) <= 0).all()
    assert (lows < highs).all()
    assert highs[-1] - lows[-1] < 0.5 < highs[20] - lows[20]
    for n in (1, 50, 150):
        part = confidence_sequence(values[:n], LIMIT, **PAIRS)
        assert part[0] == pytest.approx(lows[: len(part[0])])
        assert part[1] == pytest.approx(highs[: len(part[1])])


def test_an_interval_that_would_leave_nothing_is_left_out():
    lows, highs = confidence_sequence([1] * 30 + [0] * 400, LIMIT)
    assert (lows < highs).all()
    assert lows[-1] > 0.7
    assert (lows[-1], highs[-1]) == (lows[60], highs[60])
