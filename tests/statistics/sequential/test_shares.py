"""Shares of solved trials at every look."""

import math

import numpy as np
import pytest

from lockprobe.statistics.sequential.betting import SHARES, confidence_sequence
from lockprobe.statistics.sequential.shares import share_at_every_look


def test_the_interval_is_the_last_of_the_sequence_in_the_order_of_trials():
    solved = np.random.default_rng(1).random(60) < 0.3
    found = share_at_every_look(solved)
    lows, highs = confidence_sequence(solved * 1.0, math.log(20), bets=SHARES)
    assert (found.low, found.high) == pytest.approx((lows[-1], highs[-1]))
    assert (found.count, found.n, found.value) == (solved.sum(), 60, solved.mean())


def test_a_higher_level_is_a_wider_interval_of_the_same_trials():
    found = share_at_every_look([i % 3 == 0 for i in range(40)])
    wider = share_at_every_look([i % 3 == 0 for i in range(40)], 1 - 0.05 / 10)
    assert wider.low < found.low < found.value < found.high < wider.high
    assert (wider.count, wider.n) == (found.count, found.n)


def test_all_or_none_solved_and_no_trial():
    assert share_at_every_look([True] * 20).high == 1
    assert 0.75 < share_at_every_look([True] * 20).low < 0.85
    assert share_at_every_look([False] * 20).low == 0
    nothing = share_at_every_look([])
    assert (nothing.n, nothing.low, nothing.high) == (0, 0, 1)
    assert math.isnan(nothing.value)
