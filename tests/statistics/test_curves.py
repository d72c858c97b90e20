"""Incidence by step: by hand, the plain share, the library's with censoring, and bands that hold."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from scipy import stats

from lockprobe.statistics.curves import incidence, success_curve
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.proportions import proportion


def curve_of(trials):
    return success_curve(outcomes(trials))


def solved_at(steps, *, n, budget=20):
    """Trials solved at these steps, and others that are not, n in all."""
    waits = [make_trial([0] * (step - 4) + list(SOLUTION), budget=budget) for step in steps]
    return waits + [make_trial([0] * budget, budget=budget)] * (n - len(steps))


def test_steps_and_shares_by_hand():
    curve = curve_of(solved_at([4, 4, 6], n=4))
    assert (curve.n, len(curve.share), curve.share[3:7]) == (4, 21, (0.0, 0.5, 0.5, 0.75))
    assert (curve.steps_to(0.5), curve.steps_to(0.75), curve.steps_to(0.8)) == (4, 6, None)
    assert curve.restricted_mean_steps == pytest.approx((4 + 4 + 6 + 20) / 4)


def test_a_step_lies_in_its_interval_which_is_open_where_the_band_does_not_reach_the_share():
    curve = curve_of(solved_at(range(4, 20), n=20))
    early, late = curve.steps_to_interval(0.5)
    assert early <= curve.steps_to(0.5) <= late
    assert curve.high[early - 1] < 0.5 <= curve.high[early]
    assert curve.low[late - 1] < 0.5 <= curve.low[late]
    assert curve.steps_to_interval(0.8)[1] is None
    assert curve_of(solved_at([], n=30)).steps_to_interval(0.5) == (None, None)


@pytest.mark.parametrize("seed", range(12))
def test_it_is_the_plain_share_without_early_censoring_and_the_librarys_with_it(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 98))
    steps, solved = rng.integers(1, 21, n), rng.random(n) < rng.choice([0.02, 0.5, 0.95])
    whole, censored = (incidence(one, solved, 20) for one in (np.where(solved, steps, 20), steps))
    for step in range(21):
        plain = proportion(int(np.sum(solved & (steps <= step))), n)
        assert whole.share[step] == plain.value
        assert (whole.low[step], whole.high[step]) == pytest.approx((plain.low, plain.high), abs=1e-9)
    library = stats.ecdf(stats.CensoredData.right_censored(steps, ~solved)).cdf
    assert censored.share == pytest.approx(library.evaluate(np.arange(21.0)).tolist(), abs=1e-12)
    low, share, high = map(np.array, (censored.low, censored.share, censored.high))
    assert np.all((low >= 0) & (low <= share) & (share <= high) & (high <= 1))
