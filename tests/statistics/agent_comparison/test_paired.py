"""Blocks of luck: the exact test against counting all signs, intervals that hold the truth, missing trials."""

from itertools import product

import numpy as np
import pytest
from builders import make_trial

from lockprobe.statistics.agent_comparison.paired import block_mean, sheets, sign_flip
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.proportions import paired


@pytest.mark.parametrize("sums", [[1, 2, 3], [4, -4, 2, 0], [7, 7, 7, 7, -1, 2], [3, 1, -1, 5, 2, 2, 6, -7]])
def test_the_exact_test_counts_all_signs(sums):
    away = abs(sum(sums))
    every = [
        abs(sum(s * size for s, size in zip(signs, sums, strict=True))) for signs in product((1, -1), repeat=len(sums))
    ]
    assert sign_flip(np.array(sums, dtype=float)) == pytest.approx(np.mean(np.array(every) >= away))


def test_blocks_that_do_not_differ_tell_nothing():
    assert sign_flip(np.zeros(9)) == 1.0
    assert sign_flip(np.array([0.0, 0.0, 5.0])) == 1.0


def test_very_many_blocks_are_taken_as_normal_which_is_close_to_exact():
    rng = np.random.default_rng(1)
    sums = rng.integers(-60, 70, size=1500).astype(float)
    drawn = np.abs((rng.integers(0, 2, size=(4000, 1500)) * 2 - 1) @ sums)
    assert sign_flip(sums) == pytest.approx(np.mean(drawn >= abs(sums.sum())), abs=0.05)
    assert sign_flip(sums[:1000]) == pytest.approx(sign_flip(sums[:1000] * 1.0 * 3), abs=1e-12)


def test_one_pair_in_every_block_is_mcnemars_test():
    rng = np.random.default_rng(2)
    first, second = rng.random(40) < 0.4, rng.random(40) < 0.7
    found = block_mean((second * 1.0 - first)[:, None], unit=1.0)
    mcnemar = paired(first, second)
    assert found.p_value == pytest.approx(mcnemar.p_value)
    assert found.value == pytest.approx(mcnemar.value)
    assert (found.low, found.high) == pytest.approx((mcnemar.low, mcnemar.high), abs=0.05)


def test_trials_that_share_their_luck_count_once():
    """Seven copies of one column are no more than one of it."""
    column = np.repeat([1.0, 0.0, -1.0], [12, 10, 4])[:, None]
    once, often = block_mean(column, unit=1.0), block_mean(np.tile(column, 7), unit=1.0)
    assert often.value == pytest.approx(once.value)
    assert often.p_value == pytest.approx(once.p_value)
    assert often.high - often.low == pytest.approx(once.high - once.low, abs=0.02)
    assert (often.pairs, often.blocks) == (182, 26)


def test_missing_pairs_are_in_no_number():
    differences = np.array([[1.0, np.nan], [np.nan, np.nan], [0.0, 1.0], [-1.0, 0.0]])
    found = block_mean(differences, unit=1.0)
    assert (found.pairs, found.blocks, found.value) == (5, 3, pytest.approx(0.2))
    assert block_mean(np.full((3, 2), np.nan)).p_value is None


def test_agents_that_never_differ_are_still_not_surely_equal():
    found = block_mean(np.zeros((30, 7)), unit=1.0)
    assert found.p_value == 1.0
    assert found.high == -found.low
    assert 0.03 < found.high < 0.2
    assert block_mean(np.zeros((30, 7))).low is None
    assert block_mean(np.ones((1, 7)), unit=1.0).low is None


def test_blocks_that_all_differ_alike_have_an_interval_where_the_most_that_a_trial_differs_by_is_known():
    """Ten blocks one step faster may hide one in which the agent fails; sixteen steps faster they cannot."""
    assert block_mean(np.full((10, 7), -1.0)).low is None
    assert not block_mean(np.full((10, 7), -1.0)).clear
    assert not block_mean(np.full((10, 7), -1.0), unit=19.0).clear
    assert block_mean(np.full((10, 7), -16.0), unit=19.0).clear


def test_what_has_not_ended_is_missing():
    one = outcomes([make_trial([3, 2, 1, 0], p=0.0), make_trial([0], p=0.3, trial=2, broken="model")])
    two = outcomes([make_trial([0] * 20, p=0.3, trial=2)])
    values, (first, second) = sheets([one, two])
    assert values == (0.0, 0.3)
    assert np.isnan(first.solved).tolist() == [[False, True], [True, True]]
    assert second.steps[1, 1] == 20
    assert sheets([]) == ((), [])
