"""The five scores of a suite: their zero and their one, their formulas, and how often their intervals hold the truth."""

from itertools import product
from statistics import fmean

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, t

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_success
from lockprobe.statistics.behaviour import behaviour
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.rationality import rationality
from lockprobe.statistics.suite.scores import LevelTrials, mean_difference, share_over_levels, suite_score

CHANCE = random_success(box("chain-4"), 20)
UNSOLVED = (1,) * 20


def level(told, misled=(), *, chance=CHANCE, judged=True):
    """A level with so many trials solved and unsolved, or with these trials."""
    made = [
        part if not all(isinstance(one, int) for one in part)
        else [make_trial(SOLUTION if i < part[0] else UNSOLVED, p=p, trial=i + 1) for i in range(sum(part))]
        for p, part in ((0.0, told), (0.4, misled))
    ]  # fmt: skip
    return LevelTrials(box="chain-4", chance=chance, told=made[0], misled=made[1], judged=judged)


def test_competence_is_0_at_chance_and_1_where_every_box_is_opened():
    assert suite_score([level((6, 0))] * 2).competence.value == 1
    assert suite_score([level((1, 1), chance=0.5)]).competence.value == 0
    assert suite_score([level((0, 4), chance=0.5)]).competence.value == -1


@given(
    solved=st.lists(st.integers(0, 12), min_size=1, max_size=4), chance=st.floats(0, 0.9), together=st.integers(1, 20)
)
def test_competence_weighs_levels_alike_and_has_the_exact_interval_of_all_trials(solved, chance, together):
    found = suite_score([level((k, 12 - k), chance=chance) for k in solved], together=together).competence
    whole = binomtest(sum(solved), 12 * len(solved)).proportion_ci(1 - 0.05 / together, "exact")
    assert [found.value, found.low, found.high] == pytest.approx(
        [(share - chance) / (1 - chance) for share in (fmean(solved) / 12, whole.low, whole.high)]
    )


_GRID = (0.0, 0.002, 0.01, 0.05, 0.2, 0.5, 0.7, 0.9, 0.98, 0.995, 1.0)


@pytest.mark.parametrize("together", [1, 20])
@pytest.mark.parametrize("sizes", [(1, 1), (3, 3), (12, 12), (1, 2), (1, 30), (5, 6), (12, 30), (4, 4, 4), (2, 5, 9)])
def test_the_interval_over_levels_misses_no_more_often_than_its_level_whatever_each_level_has(sizes, together):
    """Every outcome of every world is counted, near floor and ceiling and with levels of unequal size."""
    outcomes = list(product(*(range(size + 1) for size in sizes)))
    counts = np.array(outcomes)
    found = [share_over_levels([proportion(*of) for of in zip(one, sizes, strict=True)], together) for one in outcomes]
    low, high = np.array([(one.low, one.high) for one in found]).T
    of_level = [binom.pmf(np.arange(size + 1)[:, None], size, _GRID) for size in sizes]
    for world in product(range(len(_GRID)), repeat=len(sizes)):
        truth = fmean(_GRID[i] for i in world)
        chances = np.prod([of_level[j][counts[:, j], i] for j, i in enumerate(world)], axis=0)
        missed = (low > truth + 1e-12) | (high < truth - 1e-12)
        assert chances[missed].sum() <= 0.05 / together, world


@pytest.mark.parametrize("success", [(0.98,) * 4, (0.99, 0.97, 0.95, 0.9), (0.01, 0.02, 0.02, 0.05)])
def test_no_agent_of_a_suite_lies_outside_its_interval_more_often_than_said(success):
    """300 suites of 20 agents. With the intervals of the levels combined, some agent does in 0.4 to 0.7 of them."""
    solved = np.random.default_rng(1).binomial(36, success, size=(300, 20, 4))
    missed = 0
    for suite in solved.tolist():
        found = [share_over_levels([proportion(count, 36) for count in agent], 20) for agent in suite]
        missed += any(not one.low <= fmean(success) <= one.high for one in found)
    assert missed <= 300 * 0.05


def test_robustness_is_the_change_of_the_competence_in_pairs_of_trials():
    one, other = level((6, 2), (3, 5)), level((4, 4), (5, 3))
    found = suite_score([one, other]).robustness
    told, misled = (
        suite_score([level(part, chance=CHANCE) for part in parts]).competence.value
        for parts in (((6, 2), (4, 4)), ((3, 5), (5, 3)))
    )
    assert found.value == pytest.approx(misled - told)
    alone = suite_score([one]).robustness
    apart = np.array([-1.0] * 3 + [0.0] * 5)
    half = t.ppf(0.975, 7) * np.sqrt((((apart - apart.mean()) ** 2).sum() + 1) / 7 / 8)
    assert (alone.low, alone.high) == pytest.approx(
        [max(-1, end) / (1 - CHANCE) for end in (-3 / 8 - half, -3 / 8 + half)]
    )


def test_an_agent_that_opens_nothing_has_no_robustness_and_one_that_opens_everything_has():
    assert suite_score([level((0, 8), (0, 8))] * 2).robustness is None
    assert suite_score([level((0, 8), (0, 8)), level((0, 8), (1, 7))]).robustness.value > 0
    assert suite_score([level((8, 0), (8, 0))] * 2).robustness.low < 0


def test_intervals_hold_for_all_agents_at_once():
    levels = [level((6, 2), (3, 5)), level((4, 4), (5, 3))]
    alone, of_ten = suite_score(levels), suite_score(levels, together=10)
    for one, other in ((alone.competence, of_ten.competence), (alone.robustness, of_ten.robustness)):
        assert one.value == other.value
        assert other.low < one.low < one.high < other.high
    assert (alone.loops, alone.misreading) == (of_ten.loops, of_ten.misreading)


@pytest.mark.parametrize("rates", [(0.8, 0.65, 0.5, 0.3), (0.98, 0.95, 0.9, 0.8), (0.3, 0.1, 0.03, 0.01)])
def test_a_difference_of_equal_agents_excludes_0_no_more_often_than_its_level(rates):
    """300 pairs of agents at the level of one comparison, and as the clearest of ten."""
    rng = np.random.default_rng(1)
    found, many = 0, 0
    for _ in range(300):
        both = [rng.random((36, 2)) < rate for rate in rates]
        single, tenth = mean_difference(both), mean_difference(both, 10)
        found += single.low > 0 or single.high < 0
        many += tenth.low > 0 or tenth.high < 0
    assert found <= 300 * 0.05 + 2.5 * np.sqrt(300 * 0.05 * 0.95)
    assert many <= 6


def test_loops_and_rationality_are_those_of_the_trials_told_the_truth():
    told = [make_trial([0, 1, 2] * 6, trial=1), make_trial([1, 1, 2, 0, 3, 2, 1, 0], trial=2)]
    found = suite_score([level(told, [make_trial([0, 1, 2] * 6, p=0.4)])])
    seen = behaviour(told)
    assert found.loops.value == pytest.approx(seen.loops.value - seen.chance_uniform)
    count = seen.loops.count
    whole = binomtest(count, 2).proportion_ci(0.95, "exact")
    assert (found.loops.low + seen.chance_uniform, found.loops.high + seen.chance_uniform) == pytest.approx(whole)
    judged = rationality(told)[0]
    assert found.rationality.value == pytest.approx(judged.optimal.value)
    assert (found.rationality.low, found.rationality.high) == pytest.approx((judged.optimal.low, judged.optimal.high))
    assert found.rationality.chance == pytest.approx(judged.by_chance["optimal"])
    assert found.rationality.actions == 26


def test_only_levels_that_the_prior_holds_are_judged():
    both = suite_score([level((2, 2)), level((4, 0), judged=False)])
    assert both.rationality == suite_score([level((2, 2))]).rationality
    assert suite_score([level((2, 2), judged=False)]).rationality is None


def test_misreading_is_of_all_claims_under_both_kinds_of_reports():
    told = [make_trial([0, 1, 2], claims=[None, "moved", "blocked"], trial=1)]
    misled = [make_trial([0, 1, 2], p=0.4, false_at=[1], claims=[None, "moved", "moved"], trial=1)]
    assert suite_score([level(told, misled)]).misreading.value == pytest.approx(2 / 4)
    assert suite_score([level((2, 2), (2, 2))]).misreading is None


def test_a_level_without_a_trial_that_ended_leaves_no_score_and_broken_trials_count_apart():
    found = suite_score([level((3, 1), (2, 2)), level([make_trial([0], broken="model")], [])])
    assert (found.competence, found.robustness, found.loops, found.rationality) == (None, None, None, None)
    assert (found.trials, found.broken) == (8, 1)
    assert [one.told.n for one in found.levels] == [4, 0]
