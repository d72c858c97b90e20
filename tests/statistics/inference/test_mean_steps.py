"""Mean steps over p: Student's paired test by hand, crossing curves that a log-rank test misses, and people."""

from functools import partial

import numpy as np
import pytest
from scipy import stats

from lockprobe.statistics.inference.hazard import log_rank
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
    found, changes = mean_steps(paired(first, second, third), BUDGET), (second + third) / 2 - first
    lowest, higher = first.mean(), (second + third).mean() / 2
    below, above = (
        np.hypot(stats.sem(changes), np.sqrt(3) * max(BUDGET - one, other - 4) / 40)
        for one, other in ((higher, lowest), (lowest, higher))
    )
    assert (found.value, found.n) == (pytest.approx(changes.mean()), 80)
    error = below if found.value > 0 else above
    assert found.p_value == pytest.approx(2 * stats.t.sf(abs(changes.mean()) / error, 39))
    reach = stats.t.ppf(0.975, 39)
    ends = changes.mean() - reach * below, changes.mean() + reach * above
    assert (found.low, found.high) == pytest.approx(ends)


def mostly_faster(blocks, rng, *, mean, slow, values, budget):
    """Equal means: one step more or less told the truth; otherwise fewer, but now and then the whole budget."""
    first = rng.integers(mean - 1, mean + 2, size=blocks)
    usual = (mean - slow * budget) / (1 - slow)
    short = np.floor(usual) + (rng.random((values, blocks)) < usual % 1)
    stuck = rng.random((1, blocks)) < slow
    return first, *np.where(stuck, budget, short).astype(int)


def false_changes(draw, *, budget, studies=400):
    """The larger of the shares of studies with a change, and with an interval that leaves out 0."""
    found = [mean_steps(paired(*draw(np.random.default_rng([i, budget]))), budget) for i in range(studies)]
    return max(np.mean([one.p_value < 0.05 for one in found]), np.mean([not one.low <= 0 <= one.high for one in found]))


@pytest.mark.parametrize(
    ("budget", "blocks", "values", "mean", "slow"),
    [(20, 10, 1, 6, 0.05), (20, 18, 1, 5, 0.17), (20, 30, 6, 6, 0.05), (40, 60, 1, 6, 0.04), (100, 100, 6, 6, 0.025)],
)
def test_rare_long_trials_are_no_decrease_at_any_budget(budget, blocks, values, mean, slow):
    """Most samples have too few long trials. With a single block in the variance, 0.10 find a decrease at 100 steps."""
    world = partial(mostly_faster, blocks, mean=mean, slow=slow, values=values, budget=budget)
    assert false_changes(world, budget=budget) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


@pytest.mark.parametrize(("budget", "blocks"), [(20, 30), (100, 100)])
def test_rare_short_trials_are_no_increase(budget, blocks):
    """Told the truth hardly any box is opened, and that soon; otherwise as many steps in every trial."""

    def draw(rng):
        rare = 2.9 / blocks
        first = np.where(rng.random(blocks) < rare, 2, budget)
        return first, np.floor(budget - rare * (budget - 2) + rng.random(blocks)).astype(int)

    assert false_changes(draw, budget=budget) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


def test_crossing_curves_that_a_log_rank_test_misses_are_detected():
    """Told the truth it solves early or never; with false reports later, and as often."""
    rng = np.random.default_rng(2)
    truth = np.where(rng.random(300) < 0.5, rng.integers(4, 10, 300), BUDGET)
    told = np.where(rng.random(300) < 0.62, rng.integers(4, BUDGET, 300), BUDGET)
    found = paired(truth, told)
    assert log_rank(found.length, found.solved, found.dose > 0, found.cluster).p_value > 0.2
    assert mean_steps(found, BUDGET).p_value < 0.05


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
    assert several.value == pytest.approx(one.value)
    assert several.p_value == pytest.approx(one.p_value)
