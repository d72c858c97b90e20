"""Mean steps over p: Student's paired test by hand, crossing curves that a log-rank test misses, and people."""

import numpy as np
import pytest
from scipy import stats

from lockprobe.analysis.inference.logrank import solution_logrank
from lockprobe.analysis.inference.mean_steps import mean_steps
from lockprobe.analysis.outcomes import Outcomes

BUDGET = 20


def columns(steps, p, *, player=(), trial=None):
    """Trials of these lengths; one of the whole budget is unsolved."""
    length = np.asarray(steps, dtype=np.int64)
    return Outcomes(
        p=np.asarray(p, dtype=np.float64),
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


def test_it_is_students_paired_test_of_the_mean_over_higher_flip_rates():
    rng = np.random.default_rng(1)
    first, second, third = rng.integers(4, BUDGET + 1, size=(3, 40))
    found = mean_steps(paired(first, second, third))
    reference = stats.ttest_rel((second + third) / 2, first)
    assert (found.lowest, found.higher) == (first.mean(), pytest.approx((second + third).mean() / 2))
    assert found.p_value == pytest.approx(reference.pvalue)
    interval = reference.confidence_interval()
    assert (found.low, found.high) == (pytest.approx(interval.low), pytest.approx(interval.high))


def test_a_trial_without_its_pair_does_not_count():
    whole = paired([5, 9, 20, 7], [8, 20, 20, 6])
    more = columns([*whole.length, 4, 4], [*whole.p, 0.0, 0.1], trial=[*whole.trial, 8, 9])
    assert mean_steps(more) == mean_steps(whole)


def test_crossing_curves_that_a_log_rank_test_misses_are_detected():
    """Told the truth it solves early or never; with false reports later, and as often."""
    rng = np.random.default_rng(2)
    truth = np.where(rng.random(300) < 0.5, rng.integers(4, 10, 300), BUDGET)
    told = np.where(rng.random(300) < 0.62, rng.integers(4, BUDGET, 300), BUDGET)
    found = paired(truth, told)
    assert solution_logrank(found).primary.p_value > 0.2
    assert mean_steps(found).p_value < 0.05


def test_trials_that_all_go_alike_do_not_differ():
    found = mean_steps(paired([5, 9, 20], [5, 9, 20]))
    assert (found.change, found.p_value, found.low, found.high) == (0, 1.0, None, None)


@pytest.mark.parametrize(
    ("found", "note"),
    [
        (columns([5, 6], [0, 0], trial=[1, 2]), "fewer than two p"),
        (columns([5, 6], [0, 0.4], trial=[1, 2]), "no common trial"),
        (columns([5, 6], [0, 0.4], trial=[1, 1]), "too few clusters"),
        (columns([], [], trial=[]), "fewer than two p"),
    ],
)
def test_what_cannot_be_tested_says_why(found, note):
    assert (mean_steps(found).p_value, mean_steps(found).note) == (None, note)


def test_trials_of_one_person_are_taken_together():
    """Copies of each person's trial add nothing; taken as independent they would."""
    rng = np.random.default_rng(3)
    skill = rng.integers(5, 15, size=12)
    p = np.repeat([0.0, 0.4], 6)
    once = columns(skill, p, player=[f"person-{i}" for i in range(12)], trial=np.arange(12))
    many = columns(np.repeat(skill, 10), np.repeat(p, 10), player=np.repeat(once.player, 10), trial=np.arange(120))
    one, several = mean_steps(once), mean_steps(many)
    assert several.change == pytest.approx(one.change)
    assert several.p_value == pytest.approx(one.p_value)


def test_two_people_are_too_few():
    found = columns([5, 9, 12, 20], [0, 0, 0.4, 0.4], player=["a", "a", "b", "b"], trial=[1, 2, 3, 4])
    assert mean_steps(found).note == "too few clusters"
