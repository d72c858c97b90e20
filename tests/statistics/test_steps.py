"""Mean steps over doses: Student's paired test by hand, rare blocks, crossing curves that log-rank tests miss, people."""

from functools import partial

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from scipy import stats
from solved import columns

from lockprobe.statistics.hazards import log_rank, steps_over_doses
from lockprobe.statistics.outcomes import outcomes

BUDGET = 20


def paired(*by_p, budget=BUDGET):
    """One row of steps for each p, trial by trial with the same luck."""
    n = len(by_p[0])
    p = np.repeat(np.arange(len(by_p)) / 10, n)
    return columns(p, np.tile(np.arange(1, n + 1), len(by_p)), length=np.concatenate(by_p), budget=budget)


@pytest.mark.parametrize("seed", range(8))
def test_it_is_students_paired_test_with_three_rare_blocks_in_the_variance(seed):
    rng = np.random.default_rng(seed)
    first, second, third = rng.integers([[4 + seed % 4], [4], [4]], BUDGET + 1, size=(3, 40))
    found, changes = steps_over_doses(paired(first, second, third)), (second + third) / 2 - first
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
    assert (found.p_value < 0.05) == (found.low > 0 or found.high < 0)


def mostly_faster(blocks, rng, *, mean, slow, values, budget):
    """Equal means: one step more or less told the truth; otherwise fewer, but now and then the whole budget."""
    first = rng.integers(mean - 1, mean + 2, size=blocks)
    usual = (mean - slow * budget) / (1 - slow)
    short = np.floor(usual) + (rng.random((values, blocks)) < usual % 1)
    stuck = rng.random((1, blocks)) < slow
    return first, *np.where(stuck, budget, short).astype(int)


def false_changes(draw, *, budget, studies=400):
    """The larger of the shares of studies with a change, and with an interval that leaves out 0."""
    found = [steps_over_doses(paired(*draw(np.random.default_rng([i, budget])), budget=budget)) for i in range(studies)]
    return max(np.mean([one.p_value < 0.05 for one in found]), np.mean([not one.low <= 0 <= one.high for one in found]))


@pytest.mark.parametrize(
    ("budget", "blocks", "values", "mean", "slow"),
    [(20, 18, 1, 5, 0.17), (20, 30, 6, 6, 0.05), (100, 100, 6, 6, 0.025)],
)
def test_rare_long_trials_are_no_decrease_at_any_budget(budget, blocks, values, mean, slow):
    """Most samples have too few long trials. With a single block in the variance, 0.10 find a decrease at 100 steps."""
    world = partial(mostly_faster, blocks, mean=mean, slow=slow, values=values, budget=budget)
    assert false_changes(world, budget=budget) <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 400)


def test_crossing_curves_that_a_log_rank_test_misses_are_detected():
    """Told the truth it solves early or never; with false reports later, and as often."""
    rng = np.random.default_rng(2)
    truth = np.where(rng.random(300) < 0.5, rng.integers(4, 10, 300), BUDGET)
    told = np.where(rng.random(300) < 0.62, rng.integers(4, BUDGET, 300), BUDGET)
    found = paired(truth, told)
    assert log_rank(found.length, found.solved, found.dose > 0, found.cluster).p_value > 0.2
    assert steps_over_doses(found).p_value < 0.05


def over_doses(played):
    return steps_over_doses(outcomes(played))


def test_a_change_of_steps_holds_at_both_ends_of_what_broken_trials_can_have_become():
    quick = [make_trial(SOLUTION, trial=i) for i in range(30)]
    slow = [make_trial([0] * 10 + [*SOLUTION], p=0.4, trial=i) for i in range(30)]
    broke = [make_trial([0, 0], p=0.4, trial=i, broken="model") for i in range(30)]
    whole, few = (over_doses([*quick, *broke[:n], *slow[n:]]) for n in (0, 2))
    assert whole == steps_over_doses(outcomes([*quick, *slow]))
    assert (whole.value, few.value) == (10, 10)
    solved = [make_trial([0, *SOLUTION][-3:], p=0.4, trial=i) for i in range(2)]
    never = [make_trial([0] * 20, p=0.4, trial=i) for i in range(2)]
    ends = [steps_over_doses(outcomes([*quick, *gone, *slow[2:]])) for gone in (solved, never)]
    assert few.low == pytest.approx(min(one.low for one in ends))
    assert few.high == pytest.approx(max(one.high for one in ends))
    assert few.p_value == pytest.approx(max(one.p_value for one in ends))
    assert few.p_value < 0.05
    a_little = [make_trial([0] * 3 + [*SOLUTION], p=0.4, trial=i) for i in range(30)]
    assert over_doses([*quick, *broke[:23], *a_little[23:]]).p_value == 1.0  # those may have been solved at once
    assert over_doses([*quick, *broke]).p_value is None
