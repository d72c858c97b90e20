"""Mean steps over p: Student's paired test by hand, crossing curves that a log-rank test misses, and people."""

import numpy as np
import pytest
from scipy import stats

from lockprobe.statistics.inference.logrank import solution_logrank
from lockprobe.statistics.inference.mean_steps import mean_steps
from lockprobe.statistics.outcomes import Outcomes

BUDGET = 20


def columns(steps, p, *, player=(), trial=None):
    """Trials of these lengths; one of the whole budget is unsolved."""
    length = np.asarray(steps, dtype=np.int64)
    return Outcomes(
        dose=np.asarray(p, dtype=np.float64),
        repetition=np.ones(len(length), dtype=np.int64),
        trial=np.asarray(trial, dtype=np.int64),
        length=length,
        solved=length < BUDGET,
        onset=np.zeros(len(length), dtype=np.int64),
        player=np.asarray(player, dtype=np.str_),
    )


def paired(*by_p):
    """One row of steps for each p, trial by trial with the same luck."""
    n = len(by_p[0])
    p = np.repeat(np.arange(len(by_p)) / 10, n)
    return columns(np.concatenate(by_p), p, trial=np.tile(np.arange(1, n + 1), len(by_p)))


def test_it_is_students_paired_test_with_three_rare_blocks_in_the_variance():
    rng = np.random.default_rng(1)
    first, second, third = rng.integers(4, BUDGET + 1, size=(3, 40))
    found = mean_steps(paired(first, second, third), BUDGET)
    changes = (second + third) / 2 - first
    below, above = (
        np.hypot(stats.sem(changes), np.sqrt(3) * max(BUDGET - one, other - 4) / 40)
        for one, other in ((found.higher, found.lowest), (found.lowest, found.higher))
    )
    assert (found.lowest, found.higher) == (first.mean(), pytest.approx((second + third).mean() / 2))
    error = below if found.change > 0 else above
    assert found.p_value == pytest.approx(2 * stats.t.sf(abs(changes.mean()) / error, 39))
    reach = stats.t.ppf(0.975, 39)
    assert (found.low, found.high) == (
        pytest.approx(changes.mean() - reach * below),
        pytest.approx(changes.mean() + reach * above),
    )


def mostly_faster(blocks, rng, *, mean=6, slow=0.05, values=1, budget=BUDGET):
    """Equal means: one step more or less told the truth; otherwise fewer, but now and then the whole budget."""
    first = rng.integers(mean - 1, mean + 2, size=blocks)
    usual = (mean - slow * budget) / (1 - slow)
    short = np.floor(usual) + (rng.random((values, blocks)) < usual % 1)
    stuck = rng.random((1, blocks)) < slow
    return first, *np.where(stuck, budget, short).astype(int)


def false_changes(draw, *, budget, studies=400):
    """Shares of studies with a change, and with an interval that leaves out 0."""
    found = [mean_steps(paired(*draw(np.random.default_rng([i, budget]))), budget) for i in range(studies)]
    return np.mean([one.p_value < 0.05 for one in found]), np.mean([not one.low <= 0 <= one.high for one in found])


@pytest.mark.parametrize(
    ("budget", "blocks", "values", "mean", "slow"),
    [
        (20, 10, 1, 6, 0.05),
        (20, 18, 1, 5, 0.17),
        (20, 30, 6, 6, 0.05),
        (20, 60, 2, 6, 0.05),
        (40, 30, 1, 6, 0.09),
        (40, 60, 1, 6, 0.04),
        (40, 100, 1, 6, 0.025),
        (100, 60, 1, 10, 0.038),
        (100, 100, 1, 10, 0.025),
        (100, 100, 6, 6, 0.025),
        (200, 100, 1, 10, 0.025),
    ],
)
def test_rare_long_trials_are_no_decrease_at_any_budget(budget, blocks, values, mean, slow):
    """Most samples have too few long trials. With a single block in the variance, 0.10 find a decrease at 100 steps."""
    rates = false_changes(
        lambda rng: mostly_faster(blocks, rng, mean=mean, slow=slow, values=values, budget=budget), budget=budget
    )
    assert max(rates) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


@pytest.mark.parametrize(("budget", "blocks"), [(20, 30), (100, 30), (100, 100)])
def test_rare_short_trials_are_no_increase(budget, blocks):
    """Told the truth hardly any box is opened, and that soon; otherwise as many steps in every trial."""

    def draw(rng):
        rare = 2.9 / blocks
        first = np.where(rng.random(blocks) < rare, 2, budget)
        mean = budget - rare * (budget - 2)
        return first, np.floor(mean + rng.random(blocks)).astype(int)

    assert max(false_changes(draw, budget=budget)) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


@pytest.mark.parametrize("people", [6, 20])
def test_rare_slow_people_are_no_decrease(people):
    """One person in twenty needs the whole budget in all five boxes; all others are a little faster."""
    rejected = []
    for i in range(200):
        rng = np.random.default_rng([i, people])
        stuck = np.repeat(rng.random(people) < 0.05, 5)
        after = np.where(stuck, BUDGET, rng.integers(4, 7, size=5 * people))
        before = np.where(rng.random(5 * people) < 0.75, 6, rng.integers(4, 8, size=5 * people))
        steps, p = np.concatenate([before, after]), np.repeat([0.0, 0.4], 5 * people)
        who = [f"person-{i // 5}" for i in range(10 * people)]
        found = columns(steps, p, player=who, trial=np.arange(10 * people))
        rejected.append(mean_steps(found, BUDGET).p_value < 0.05)
    assert np.mean(rejected) <= 0.05


def test_crossing_curves_that_a_log_rank_test_misses_are_detected():
    """Told the truth it solves early or never; with false reports later, and as often."""
    rng = np.random.default_rng(2)
    truth = np.where(rng.random(300) < 0.5, rng.integers(4, 10, 300), BUDGET)
    told = np.where(rng.random(300) < 0.62, rng.integers(4, BUDGET, 300), BUDGET)
    found = paired(truth, told)
    assert solution_logrank(found).primary.p_value > 0.2
    assert mean_steps(found, BUDGET).p_value < 0.05


def test_trials_that_all_go_alike_do_not_differ():
    found = mean_steps(paired([5, 9, 20], [5, 9, 20]), BUDGET)
    assert (found.change, found.p_value) == (0, 1.0)
    assert (found.low, found.high) == (-BUDGET, BUDGET)


def test_trials_that_all_differ_alike_differ_where_there_are_enough():
    few, many = (mean_steps(paired([12] * n, [6] * n), BUDGET) for n in (5, 30))
    assert few.p_value > 0.05
    assert many.p_value < 0.05


@pytest.mark.parametrize(
    ("found", "note"),
    [
        (columns([5, 6], [0, 0], trial=[1, 2]), "fewer than two doses"),
        (columns([5, 6], [0, 0.4], trial=[1, 2]), "no common trial"),
        (columns([5, 6], [0, 0.4], trial=[1, 1]), "too few clusters"),
        (columns([], [], trial=[]), "fewer than two doses"),
    ],
)
def test_what_cannot_be_tested_says_why(found, note):
    assert (mean_steps(found, BUDGET).p_value, mean_steps(found, BUDGET).note) == (None, note)


def test_trials_of_one_person_are_taken_together():
    """Copies of each person's trial add nothing; taken as independent they would."""
    rng = np.random.default_rng(3)
    skill = rng.integers(5, 15, size=12)
    p = np.repeat([0.0, 0.4], 6)
    once = columns(skill, p, player=[f"person-{i}" for i in range(12)], trial=np.arange(12))
    many = columns(np.repeat(skill, 10), np.repeat(p, 10), player=np.repeat(once.player, 10), trial=np.arange(120))
    one, several = mean_steps(once, BUDGET), mean_steps(many, BUDGET)
    assert several.change == pytest.approx(one.change)
    assert several.p_value == pytest.approx(one.p_value)
