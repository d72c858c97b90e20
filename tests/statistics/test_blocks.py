"""The contrast over blocks of luck: the test against all signs, intervals that hold the truth, people as clusters."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from builders import make_trial
from scipy import stats
from solved import left_after_failures

from lockprobe.statistics.blocks import (
    FEWEST,
    block_mean,
    blocks_of,
    crossed_mean,
    mean_of_blocks,
    rare_block,
    sign_flip,
)
from lockprobe.statistics.distributions import sign_test
from lockprobe.statistics.every_look import Numbers, at_every_look
from lockprobe.statistics.outcomes import BlockOrder, outcomes
from lockprobe.statistics.pairs import FEW, paired, score_interval


def test_copies_of_a_column_are_no_more_than_one_and_one_is_mcnemars_test():
    rng = np.random.default_rng(2)
    first, second = rng.random(40) < 0.4, rng.random(40) < 0.7
    column, mcnemar = (second * 1.0 - first)[:, None], paired(first, second)
    exact = sign_test(int((first & ~second).sum()), int((second & ~first).sum()))
    once, often = mean_of_blocks(column, unit=1.0), mean_of_blocks(np.tile(column, 7), unit=1.0)
    for found in (once, often):
        assert (found.value, found.p_value, found.clusters) == pytest.approx((mcnemar.value, exact, 40))
        assert (found.low, found.high) == pytest.approx((mcnemar.low, mcnemar.high), abs=0.05)
    assert (often.n, once.n) == (280, 40)


@pytest.mark.parametrize("sizes", [[7] * 9, [1, 3, 3, 7, 2, 5], [2, 2]])
def test_a_mean_has_students_interval_with_a_pair_more_of_each_column(sizes):
    """Of a ratio of sums; where all blocks are alike, one of them counts as a trial."""
    rng, there = np.random.default_rng(len(sizes)), np.arange(7) < np.array(sizes)[:, None]
    for drawn in (rng.integers(-2, 3, there.shape) * 1.0, np.ones(there.shape)):
        differences, n, pairs = np.where(there, drawn, np.nan), len(sizes), sum(sizes)
        found, wider = (block_mean(differences, unit=2.0, rare=rare) for rare in (None, (1.0, 2.0)))
        sums, value = (drawn * there).sum(axis=1), float((drawn * there).sum() / pairs)
        spread = float(((sums - value * np.array(sizes)) ** 2).sum())
        more, each = 4 * max(sizes) ** (2 if spread < 1e-9 else 1), np.array([1, 2])
        reach = np.sqrt(n / (n - 1) * (spread + more)) / pairs * (at := stats.t.ppf(0.975, n - 1))
        below, above = np.sqrt(n / (n - 1) * spread + 3 * (max(sizes) * each) ** 2) / pairs * at  # three rare blocks
        assert (wider.low, wider.high) == pytest.approx((max(-2, value - below), min(2, value + above)))
        assert (found.value, found.n, found.clusters) == (pytest.approx(value), pairs, n)
        assert (found.low, found.high) == pytest.approx((max(-2, value - reach), min(2, value + reach)))
        assert (found.p_value is None) == (n < FEWEST)


@pytest.mark.parametrize("differ", [(0, 2), (1, 4), (2, 4)])
def test_where_few_pairs_differ_a_share_holds_tangos_interval_too(differ):
    column = np.repeat([-1.0, 1.0, 0.0], [*differ, 24 - sum(differ)])[:, None]
    alone, found = mean_of_blocks(column, unit=1 + 1e-12), mean_of_blocks(column)
    low, high = score_interval(*differ, 24, 0.95) if sum(differ) <= FEW else (alone.low, alone.high)
    assert (found.low, found.high) == pytest.approx((min(alone.low, low), max(alone.high, high)))
    plain, scaled = block_mean(column), mean_of_blocks(column * 4, unit=4.0, factor=0.25)
    assert (plain.low, plain.high) == (scaled.low, scaled.high) == (found.low, found.high)


def test_the_sign_test_of_sums_too_large_to_count_is_that_of_a_normal_distribution():
    sums = np.random.default_rng(3).integers(-900_000, 1_000_000, 200)
    assert sign_flip(sums) == pytest.approx(2 * stats.norm.sf(abs(sums.sum()) / np.sqrt((sums**2).sum())), rel=1e-6)


@pytest.mark.parametrize(
    ("first", "second", "budget", "away"),
    [([5, 6, 7], [5, 9, 10], 20, (12, 14)), ([6, 6], [18, 20], 20, (2, 15)), ([1, 1], [1, 1], 1, (1, 1))],
)
def test_a_rare_block_takes_the_whole_budget_or_as_few_steps_as_any(first, second, budget, away):
    assert rare_block(np.array(first), np.array(second), budget) == away


def test_missing_pairs_are_in_no_number():
    differences = np.array([[1.0, np.nan], [np.nan, np.nan], [0.0, 1.0], [-1.0, 0.0]])
    found = mean_of_blocks(differences, unit=1.0)
    assert (found.n, found.clusters, found.value) == (5, 3, pytest.approx(0.2))
    empty = mean_of_blocks(np.full((3, 2), np.nan), unit=1.0)
    assert (empty.p_value, empty.n, empty.clusters) == (None, 0, 0)
    one = outcomes([make_trial([3, 2, 1, 0], p=0.0), make_trial([0], p=0.3, trial=2, broken="model")])
    blocks = blocks_of([one.ended, outcomes([make_trial([0] * 20, p=0.3, trial=2)])])
    assert np.isnan(blocks.solved).tolist() == [[False, True], [True, False]]
    assert blocks.steps[1, 1] == 20
    assert len(blocks.whole([0, 1])[0]) == 0


def test_the_box_of_a_block_stands_in_its_row_when_blocks_are_in_the_order_of_the_plan():
    made = outcomes([make_trial([0] * 20, repetition=i, trial=j) for i, j in product((1, 2), (1, 2))])
    planned = BlockOrder(plans=((2, 1), (2, 2)))  # first trial 1 of both repetitions
    blocks = blocks_of([replace(made, box=np.array(["a", "a", "b", "b"]), order=planned)])
    assert blocks.box.tolist() == ["a", "b", "a", "b"]
    assert blocks.place.tolist() == [0, 1, 2, 3]
    differences = np.array([[1, 0], [np.nan, np.nan], [1, np.nan], [-1, 1]])
    found = mean_of_blocks(differences, blocks, choices=2)  # at every look a block counts once, whatever it holds
    (ever,) = at_every_look([Numbers(values=np.array([0.5, 1, 0]), block=np.array([0, 2, 3]), bound=1.0)], agents=2)
    assert (found.value, found.low, found.high, found.p_value) == (ever.value, ever.low, ever.high, ever.p_value)
    assert (found.n, found.clusters, found.p_value) == (5, 3, 1.0)
    assert mean_of_blocks(np.full((4, 2), np.nan), blocks).p_value is None
    larger = BlockOrder(plans=((2, 1), (2, 3)))
    assert blocks_of([replace(made, order=one) for one in (planned, larger)]).order == larger


def test_few_people_are_not_tested_and_one_has_no_interval():
    def same(of, person):
        return crossed_mean(np.ones(of), np.arange(of), person, unit=1.0)

    few, enough = (same(n, np.arange(n)) for n in (FEWEST - 1, FEWEST))
    assert few.p_value is None
    assert few.low is not None
    assert 0 < enough.p_value < 0.05
    values, who = np.random.default_rng(5).integers(-1, 2, 12) * 1.0, np.arange(12)
    spread = 12 / 11 * ((values - values.mean()) ** 2).sum() + 1  # a trial each: Student's, with a pair more
    reach = np.sqrt(spread) / 12 * stats.t.ppf(0.975, 11)
    found = crossed_mean(values, who, who, unit=1.0)
    assert (found.low, found.high) == pytest.approx((values.mean() - reach, values.mean() + reach))
    one, two = (same(FEWEST, np.arange(FEWEST) % people) for people in (1, 2))
    assert (one.low, one.high, one.p_value) == (None, None, None)
    assert (two.low, two.high, two.p_value) == (-1, 1, None)


def exchanged_over_doses(rng):
    """An agent's trials go alike at every dose."""
    one, two = (np.repeat(rng.random((30, 1)) < 0.5, 7, axis=1) * 1.0 for _ in range(2))
    return mean_of_blocks(two - one, unit=1.0)


def people_who_differ(rng):
    """Thirty people differ much from each other, and each plays seven boxes."""
    seat = np.array([[(block - column) % 30 for column in range(7)] for block in range(30)])
    luck = np.repeat(np.arange(30)[:, None], 7, axis=1)
    people = 0.8 * rng.standard_normal(30)[seat] + 0.6 * rng.standard_normal(seat.shape) > 0
    apart = people * 1.0 - (rng.random(seat.shape) < 0.5)
    return crossed_mean(apart.ravel(), luck.ravel(), seat.ravel(), unit=1.0)


def able_people_who_stay(rng):
    """Sixty people leave by chance after a failure; an agent solves as many boxes. By box, a third of studies err."""
    who, solved = left_after_failures(rng)
    return crossed_mean(solved - (rng.random(len(who)) < 0.5) * 1.0, np.arange(len(who)), who, unit=1.0)


def rejections(world, studies):
    found = [world(np.random.default_rng([seed, 9])) for seed in range(studies)]
    return sum(one.clear and one.p_value < 0.05 for one in found)


@pytest.mark.parametrize("world", [exchanged_over_doses, people_who_differ, able_people_who_stay])
def test_equal_agents_are_rarely_told_apart(world):
    """So few rejections of 80 come of a level of 5 % in 999 of 1000 cases."""
    assert rejections(world, 80) <= 11


@pytest.mark.parametrize(
    ("budget", "blocks", "slow"),
    [
        (20, 10, 0.05),
        (20, 18, 0.05),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in [(20, 30, 0.05), (100, 60, 0.037), (100, 100, 0.022)]
        ),
    ],
)
def test_an_agent_with_rare_long_trials_is_not_called_faster(budget, blocks, slow):
    """Equal means; every trial is solved, so the budget shows in no failure. Without it, 0.2 to 0.6 of studies err."""
    wrong = 0
    usual = (6 - slow * budget) / (1 - slow)
    for seed in range(100):
        rng = np.random.default_rng([seed, blocks])
        first = rng.integers(5, 8, size=(blocks, 7)) * 1.0
        stuck = rng.random((blocks, 1)) < slow
        second = np.where(stuck, budget, np.floor(usual + rng.random((blocks, 7))) + rng.integers(-1, 2, (blocks, 7)))
        rare = rare_block(first, second, budget)
        found = mean_of_blocks(second - first, unit=float(budget), rare=rare)
        wrong += found.clear and found.p_value < 0.05
    assert wrong / 100 <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 100)
