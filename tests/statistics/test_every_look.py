"""What holds at every look: betting against integrals and grids, closed testing against all sets of hypotheses."""

import itertools
import math
from itertools import combinations

import numpy as np
import pytest

from lockprobe.statistics.every_look import (
    SHARES,
    Numbers,
    at_every_look,
    closed_tests,
    confidence_sequence,
    log_wealth,
    share_at_every_look,
)

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


@pytest.mark.parametrize("seed", range(2))
def test_an_interval_holds_the_means_that_no_look_has_rejected(seed):
    rng = np.random.default_rng(seed)
    values = rng.choice([-1, 0, 1], size=45, p=[0.1, 0.5, 0.4]) if seed % 2 else rng.uniform(-1, 1, 45)
    lows, highs = confidence_sequence(values, LIMIT, **PAIRS)
    grid = np.linspace(-0.995, 0.995, 200)
    kept = np.array([np.maximum.accumulate(log_wealth(values, mean, **PAIRS)) < LIMIT for mean in grid])
    for at in (0, 3, 20, 44):
        held = (grid > lows[at]) & (grid < highs[at])
        assert (held == kept[:, at]).all()


def test_an_interval_that_would_leave_nothing_is_left_out():
    lows, highs = confidence_sequence([1] * 30 + [0] * 400, LIMIT)
    assert (lows < highs).all()
    assert lows[-1] > 0.7
    assert (lows[-1], highs[-1]) == (lows[60], highs[60])


STUDIES = [
    ((0.4,), {"margin": 0.1}),
    ((0.0, 0.0, 0.6), {"margin": 0.2, "agents": 3}),
    ((0.3, 0.3, 0.3, 0.3), {"agents": 10}),
]


def numbers(rng, change, blocks=80, played=1.0, bound=1.0):
    """Differences of pairs of trials, of which a share is there."""
    block = np.flatnonzero(rng.random(blocks) < played)
    values = rng.choice([-1, 0, 1], size=len(block), p=[0.2 - 0.2 * change, 0.6 - 0.6 * change, 0.2 + 0.8 * change])
    return Numbers(values=bound * values.astype(float), block=block, bound=bound)


def family(changes, seed=1, **more):
    rng = np.random.default_rng(seed)
    return [numbers(rng, change, **more) for change in changes]


def first_blocks(members, blocks):
    """What was known of them after so many blocks."""
    kept = [one.block < blocks for one in members]
    return [
        Numbers(values=one.values[own], block=one.block[own], bound=one.bound)
        for one, own in zip(members, kept, strict=True)
    ]


@pytest.mark.parametrize(("changes", "more"), STUDIES)
def test_a_p_value_is_below_5_percent_exactly_if_the_interval_leaves_out_0(changes, more):
    for seed, played in enumerate((1.0, 0.7)):
        for one in at_every_look(family(changes, seed, played=played), **more):
            away = (one.lows > 0) | (one.highs < 0)
            assert (one.p_value < 0.05) == away.any() == (one.effect_at is not None)
            if one.effect_at is not None:
                assert one.effect_at == one.blocks[away.argmax()]


@pytest.mark.parametrize(("changes", "more"), STUDIES)
def test_what_was_said_after_some_blocks_is_said_after_more(changes, more):
    members = family(changes, 4, played=0.8)
    before = at_every_look(first_blocks(members, 1), **more)
    for blocks in (25, 70):
        now = at_every_look(first_blocks(members, blocks), **more)
        for old, new in zip(before, now, strict=True):
            assert new.p_value <= old.p_value
            assert old.low <= new.low < new.high <= old.high
            assert old.effect_at in (None, new.effect_at)
            assert old.small_at in (None, new.small_at)
            assert new.lows[: len(old.lows)] == pytest.approx(old.lows)
        before = now


def test_small_is_said_only_with_a_margin_and_beside_the_effects_of_others():
    same = Numbers(values=np.zeros(100), block=np.arange(100))
    without, alone = at_every_look([same])[0], at_every_look([same], margin=0.1)[0]
    assert without.small_at is None
    assert alone.small_at == 49
    wealth = np.exp(log_wealth(np.zeros(100), 0.1, low=-1, high=1, side="below"))
    for agents in (1, 3):
        p_values = agents * 2 / (wealth + 1)  # of the other one the wealth against "no effect" is 1
        several = at_every_look([same, same], margin=0.1, agents=agents)[1]
        assert several.small_at == 1 + np.argmax(p_values < 0.05) > 49


@pytest.mark.parametrize("many", [1, 2, 3, 5])
def test_adjusted_e_values_and_thresholds_are_those_of_all_sets_of_hypotheses(many):
    """The smallest mean of all sets with a hypothesis, and what the hardest of all sets asks for."""
    log_e = np.random.default_rng(many).normal(1.5, 2.5, (12, many))
    adjusted_e, thresholds = map(np.exp, closed_tests(log_e, 0.05))
    for row, limits, e in zip(adjusted_e, thresholds, np.exp(log_e), strict=True):
        for i in range(many):
            others = np.delete(e, i)
            sets = [np.array(part) for size in range(many) for part in combinations(others, size)]
            assert row[i] == pytest.approx(min(np.mean([e[i], *part]) for part in sets))
            assert limits[i] == pytest.approx(max(20 * (1 + len(part)) - part.sum() for part in sets))


def test_the_interval_is_the_last_of_the_sequence_in_the_order_of_trials():
    solved = np.random.default_rng(1).random(60) < 0.3
    found = share_at_every_look(solved)
    lows, highs = confidence_sequence(solved * 1.0, math.log(20), bets=SHARES)
    assert (found.low, found.high) == pytest.approx((lows[-1], highs[-1]))
    assert (found.count, found.n, found.value) == (solved.sum(), 60, solved.mean())
