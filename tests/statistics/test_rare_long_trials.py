"""Rare blocks in the variance of mean steps: how many, how far, and that interval and test say the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from lockprobe.statistics.rare_long_trials import BLOCKS, rare_block


def test_so_many_blocks_are_added_that_too_few_rare_ones_appear_in_at_most_5_percent_of_samples():
    """After k rare blocks a change is said if more than k + z sqrt(k + blocks) were to be expected; fewer would not do."""
    k = np.arange(2000)

    def wrong(blocks):
        return stats.poisson.cdf(k, k + stats.norm.isf(0.025) * np.sqrt(k + blocks)).max()

    assert wrong(BLOCKS) <= 0.05 < wrong(BLOCKS - 1)


def test_a_rare_block_takes_the_whole_budget_or_as_few_steps_as_the_shortest_trial():
    easy, hard, unseen = rare_block(6, 5, 20, 3), rare_block(19, 20, 20, 3), rare_block(19, 20, 20, 19)
    assert (easy.below, easy.above) == (15, 14)
    assert (hard.below, hard.above) == (16, 17)
    assert (unseen.below, unseen.above) == (15, 16)
    only = rare_block(1, 1, 1, 1)
    assert min(only.below, only.above) > 0


@given(
    value=st.floats(-19, 19),
    se=st.floats(0, 5),
    first=st.floats(1, 20),
    second=st.floats(1, 20),
    clusters=st.integers(2, 300),
    share=st.none() | st.floats(0.01, 1),
)
def test_interval_and_test_are_students_with_three_such_blocks(value, se, first, second, clusters, share):
    found = rare_block(first, second, 20, 1)
    low, high = found.interval(value, se, clusters, share=share)
    size = 1 / clusters if share is None else share
    below, above = (np.sqrt(se**2 + 3 * (size * one) ** 2) for one in (found.below, found.above))
    assert (low, high) == pytest.approx(
        (value - stats.t.ppf(0.975, clusters - 1) * below, value + stats.t.ppf(0.975, clusters - 1) * above)
    )
    p_value = found.p_value(value, se, clusters, share=share)
    if abs(p_value - 0.05) > 1e-9:
        assert (p_value < 0.05) == (low > 0 or high < 0)
