"""Agents beside people: trials of one luck and those of one person belong together, and neither may be forgotten."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from scipy.stats import norm

from lockprobe.statistics.agent_comparison.crossed_clusters import FEWEST, at_one_p, crossed_mean
from lockprobe.statistics.agent_comparison.pair import compare
from lockprobe.statistics.agent_comparison.paired import block_mean, sheets, sign_flip
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.rare_long_trials import rare_block

A, PEOPLE = ("llm:a", "symbolic"), ("participant", "symbolic")


def seats(blocks, columns):
    """Who plays which: everybody once in every column, and never twice in a block. Shape (blocks, columns)."""
    return np.array([[f"{(block - column) % blocks}" for column in range(columns)] for block in range(blocks)])


def drawn(rng, of_luck, of_person, seat):
    """Shares of 0.5, alike within a luck or within a person as far as these standard deviations say."""
    person = rng.standard_normal(len(seat))[np.vectorize(int)(seat)]
    alone = rng.standard_normal(seat.shape) * np.sqrt(1 - of_luck**2 - of_person**2)
    return (of_luck * rng.standard_normal((len(seat), 1)) + of_person * person + alone > 0) * 1.0


def test_without_clusters_it_is_the_mean_with_its_usual_error():
    values = np.array([1.0, 0.0, -1.0, 1.0, 1.0, 0.0, 1.0, 1.0])
    found = crossed_mean(values, np.arange(8), np.arange(8))
    alone = block_mean(values[:, None])
    assert (found.value, found.pairs, found.blocks) == (0.5, 8, 8)
    assert (found.low, found.high) == pytest.approx((0.5 - (0.5 - alone.low), alone.high))


def test_few_people_are_not_tested_and_one_has_no_interval():
    n = FEWEST - 1
    few = crossed_mean(np.ones(n), np.arange(n), np.arange(n), unit=1.0)
    assert few.p_value is None
    assert few.low is not None
    one = crossed_mean(np.ones(n), np.arange(n), np.zeros(n), unit=1.0)
    assert (one.low, one.high, one.p_value) == (None, None, None)
    enough = crossed_mean(np.ones(FEWEST), np.arange(FEWEST), np.arange(FEWEST), unit=1.0)
    assert 0 < enough.p_value < 0.05


def test_it_keeps_its_level_where_exchange_within_luck_does_not():
    """People differ much from each other. At 5 % more than 20 of 200 come once in 1000 tests."""
    seat, rng, rejected, by_exchange = seats(30, 7), np.random.default_rng(3), 0, 0
    luck = np.repeat(np.arange(30)[:, None], 7, axis=1)
    for _ in range(200):
        apart = drawn(rng, 0.0, 0.8, seat) - drawn(rng, 0.0, 0.0, seat)
        rejected += crossed_mean(apart.ravel(), luck.ravel(), seat.ravel(), unit=1.0).p_value < 0.05
        by_exchange += sign_flip(apart.sum(axis=1)) < 0.05
    assert rejected <= 20
    assert by_exchange > 20


def test_at_one_p_whole_people_are_exchanged():
    person = np.repeat(["a", "b", "c", "d", "e"], 2)
    found = at_one_p(np.ones(10), person, unit=1.0)
    assert found.p_value == 2 * 0.5**5  # and not 2 * 0.5**10, as if ten people had played
    assert found.blocks == 5


def test_agents_beside_people_are_compared_with_both_kept_together():
    seat = seats(12, 2)
    own = [
        make_trial(SOLUTION, agent="llm:a", p=p, trial=block + 1)
        for block in range(12)
        for p in (0.0, 0.4)
    ]  # fmt: skip
    people = [
        make_trial(SOLUTION if p else (0,) * 20, agent=f"participant:{seat[block, i]:0>4}", p=p, trial=block + 1)
        for block in range(12)
        for i, p in enumerate((0.0, 0.4))
    ]
    values, laid = sheets([outcomes(own), outcomes(people)])
    found = compare((A, PEOPLE), values, tuple(laid), "subjects", np.random.default_rng(1), budget=20)
    assert found.people
    assert found.success.value == -0.5
    assert [at.success.value for at in found.at] == [-1.0, 0.0]
    assert found.at[0].success.p_value == 2 * 0.5**12
    assert found.interaction.clearest.change.value == 1.0
    assert found.interaction.p_value < 0.01
    assert found.interaction.mean.low is None


def test_able_people_who_stay_are_not_said_to_solve_more():
    """Sixty people leave by chance after a failure; an agent solves as many boxes. By box, a third of studies err."""
    wrong, lower = 0, 0
    for seed in range(100):
        rng = np.random.default_rng([seed, 9])
        chance, rows = norm.cdf(rng.standard_normal(60)), []
        for i in range(60):
            for _ in range(6):
                rows.append((i, rng.random() < chance[i]))
                if not rows[-1][1] and rng.random() < 0.5:
                    break
        who, solved = np.array(rows).T
        found = crossed_mean(solved - (rng.random(len(who)) < 0.5) * 1.0, np.arange(len(who)), who, unit=1.0)
        wrong += found.p_value < 0.05 and found.low > 0
        lower += found.p_value < 0.05 and found.high < 0
    assert wrong <= 9
    assert lower <= 9


def test_at_one_p_a_person_with_many_boxes_decides_nothing_alone():
    values, person = np.array([1.0] * 20 + [-1, 0, 1, 0, -1, 1, 0, 0]), np.array(["a"] * 20 + list("bcdefghi"))
    found = at_one_p(values, person, unit=1.0)
    assert found.value > 0.6
    assert found.low < 0 < found.high
    assert found.p_value > 0.05


def test_a_person_who_is_slow_throughout_may_be_missing_among_few():
    """All of ten people are a step faster in each of five boxes; one slow person would undo that."""
    values, person = np.full(50, -1.0) + np.tile([0.5, -0.5], 25), np.repeat(np.arange(10), 5)
    narrow, wide = (
        crossed_mean(values, np.arange(50), person, unit=20.0, rare=rare) for rare in (None, rare_block(7, 6, 20, 4))
    )
    assert wide.high - wide.low > 2 * (narrow.high - narrow.low)
    assert not wide.clear
