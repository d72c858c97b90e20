"""Success by step: by hand, with shares that cannot be reached, other budgets, and people."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.curves import success_curve
from lockprobe.statistics.outcomes import broken_off, outcomes


def curve_of(trials, budget=20):
    return success_curve(outcomes(trials), broken_off(trials), budget)


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


def test_trials_of_a_smaller_budget_are_censored_and_without_trials_there_are_no_steps():
    assert curve_of(solved_at([4], n=2, budget=5) + solved_at([10], n=2)).share[10] == 1 - 0.75 * 0.5
    alone = curve_of([make_trial([0], broken="model")])
    assert (alone.n, alone.restricted_mean_steps, alone.steps_to(0.0)) == (0, None, None)


def test_the_band_of_people_counts_those_of_one_person_together():
    trials = [make_trial(SOLUTION if i < 15 else (0,) * 20, agent="llm:a", trial=i) for i in range(30)]
    people = [replace(trial, agent=f"participant:{trial.trial // 5:04d}") for trial in trials]
    alone, together = curve_of(trials), curve_of(people)
    assert together.share == alone.share
    assert together.low[-1] < alone.low[-1]
    assert together.high[-1] > alone.high[-1]
