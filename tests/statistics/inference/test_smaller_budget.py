"""Smaller budgets: McNemar's test by hand, its correction, and where there is no reversal to report."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.smaller_budget import reversal
from lockprobe.statistics.outcomes import Outcomes

BUDGET = 20


def pairs(truth, told):
    """Trials with the same luck at p = 0 and 0.4: the step of the solution, 0 if there is none."""
    steps = np.array([*truth, *told])
    n = len(truth)
    return Outcomes(
        dose=np.repeat([0.0, 0.4], n),
        repetition=np.ones(2 * n, dtype=np.int64),
        trial=np.tile(np.arange(1, n + 1), 2),
        length=np.where(steps, steps, BUDGET),
        solved=steps > 0,
        onset=np.zeros(2 * n, dtype=np.int64),
    )


def found(trials):
    return reversal(trials, any_difference(trials, np.random.default_rng(1), 500))


CROSSING = pairs([5] * 12 + [8] * 8 + [0] * 40, [9] * 5 + [15] * 40 + [0] * 15)


def test_the_clearest_smaller_budget_is_tested_with_mcnemar_and_corrected_for_all():
    one = found(CROSSING)
    assert (one.budget, one.first.count, one.second.count, one.first.n) == (8, 20, 0, 60)
    assert one.p_value == pytest.approx(binomtest(20, 20).pvalue * (BUDGET - 1))


def test_without_a_reversal_or_a_detected_difference_there_is_none():
    assert found(pairs([5] * 20 + [0] * 40, [5] * 50 + [0] * 10)) is None
    assert found(pairs([5] * 20 + [0] * 40, [0] * 40 + [15] * 20)) is None  # as many are solved
    assert found(pairs([5] * 3 + [0] * 57, [15] * 50 + [0] * 10)) is None  # three pairs show no reversal


def test_people_are_not_paired():
    people = replace(CROSSING, player=np.array([f"person-{i % 30}" for i in range(len(CROSSING))]))
    assert found(people) is None


def test_chance_reverses_no_effect_in_more_than_five_per_cent_of_studies():
    """Success rises at every step alike, so no smaller budget has the opposite effect."""
    rng = np.random.default_rng(7)
    drawn = lambda rate: np.where(rng.random(60) < rate, rng.integers(4, BUDGET, 60), 0)  # noqa: E731
    assert sum(found(pairs(drawn(0.4), drawn(0.75))) is not None for _ in range(100)) <= 5
