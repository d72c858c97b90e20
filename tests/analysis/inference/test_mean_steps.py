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


def test_it_is_students_paired_test_with_one_more_block_of_a_whole_budget():
    rng = np.random.default_rng(1)
    first, second, third = rng.integers(4, BUDGET + 1, size=(3, 40))
    found = mean_steps(paired(first, second, third), BUDGET)
    changes = (second + third) / 2 - first
    error = np.hypot(stats.sem(changes), BUDGET / 40)
    assert (found.lowest, found.higher) == (first.mean(), pytest.approx((second + third).mean() / 2))
    assert found.p_value == pytest.approx(2 * stats.t.sf(abs(changes.mean()) / error, 39))
    half = stats.t.ppf(0.975, 39) * error
    assert (found.low, found.high) == (pytest.approx(changes.mean() - half), pytest.approx(changes.mean() + half))


def mostly_faster(blocks, rng, *, slow=0.05, values=1, whole=True):
    """Equal means: 5 to 7 steps told the truth; otherwise fewer, but now and then the whole budget."""
    first = rng.integers(5, 8, size=blocks)
    usual = (6 - slow * BUDGET) / (1 - slow)
    short = np.floor(usual) + (rng.random((values, blocks)) < usual % 1)
    stuck = rng.random((1 if whole else values, blocks)) < slow
    return first, *np.where(stuck, BUDGET, short).astype(int)


@pytest.mark.parametrize(("blocks", "values"), [(10, 1), (18, 1), (18, 6), (30, 1), (30, 6), (60, 2)])
def test_rare_long_trials_are_no_decrease(blocks, values):
    """Without the added block up to six studies in ten find one, since most have too few long trials."""
    drawn = (mostly_faster(blocks, np.random.default_rng([i, blocks]), values=values) for i in range(200))
    found = [mean_steps(paired(*steps), BUDGET) for steps in drawn]
    assert np.mean([one.p_value < 0.05 for one in found]) <= 0.05
    assert np.mean([one.low <= 0 <= one.high for one in found]) >= 0.95


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


def test_a_trial_without_its_pair_does_not_count():
    whole = paired([5, 9, 20, 7], [8, 20, 20, 6])
    more = columns([*whole.length, 4, 4], [*whole.p, 0.0, 0.1], trial=[*whole.trial, 8, 9])
    assert mean_steps(more, BUDGET) == mean_steps(whole, BUDGET)


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
    assert found.low == -BUDGET
    assert found.high == BUDGET


def test_trials_that_all_differ_alike_differ_where_there_are_enough():
    few, many = (mean_steps(paired([12] * n, [6] * n), BUDGET) for n in (5, 30))
    assert few.p_value > 0.05
    assert many.p_value < 0.05


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


def test_two_people_are_too_few():
    found = columns([5, 9, 12, 20], [0, 0, 0.4, 0.4], player=["a", "a", "b", "b"], trial=[1, 2, 3, 4])
    assert mean_steps(found, BUDGET).note == "too few clusters"
