"""A misinterpretation contradicts what was told; false reports and false beliefs are counted apart."""

import numpy as np
import pytest
from builders import make_trial

from lockprobe.statistics.misinterpretation import claims, misinterpretations, trial_claims


def test_claims_are_about_the_step_before():
    # Steps: 3 moves, 2 moves, 0 is blocked. The report of step 2 is inverted.
    trial = make_trial([3, 2, 0, 0], false_at=[2], claims=[None, "blocked", "blocked", "blocked"])
    assert [(c.step, c.claimed, c.told, c.truth, c.misinterpreted) for c in claims(trial)] == [
        (1, "blocked", "moved", "moved", True),
        (2, "blocked", "blocked", "moved", False),
        (3, "blocked", "blocked", "blocked", False),
    ]


def test_table_by_hand():
    trials = [
        make_trial([3, 2, 0, 0], trial=1, false_at=[2], claims=[None, "blocked", "blocked", "blocked"]),
        make_trial([3, 0, 0], trial=2, claims=[None, "moved", None]),
        make_trial([3, 0, 0], trial=3),
        make_trial([3, 0, 0], trial=4, claims=[None, "blocked", "moved"], broken="reply"),
    ]
    found = misinterpretations(trials)
    assert (found.trials, found.affected, found.total) == (2, 1, 1)
    assert found.mean_rate == pytest.approx((1 / 3 + 0) / 2)
    assert found.sd_rate == pytest.approx(1 / 3 / 2**0.5)
    assert (found.pooled.count, found.pooled.n) == (1, 4)
    assert (found.against_truth.count, found.against_truth.n) == (2, 4)


MOVES = [3, 2, 0, 0, 3, 3]  # moved, moved, blocked, blocked, moved, moved


def answered(claims, *, false_at=(), trial=1):
    return make_trial(MOVES, trial=trial, false_at=false_at, claims=[None, *claims])


def played(seed, n=12):
    """Trials with reports and readings wrong at random."""
    rng = np.random.default_rng(seed)
    kinds = np.array(["moved", "blocked"])
    return [
        answered(
            [None if rng.random() < 0.2 else str(kinds[rng.integers(2)]) for _ in range(5)],
            false_at=[step for step in range(1, 7) if rng.random() < 0.4],
            trial=number,
        )
        for number in range(1, n + 1)
    ]


def test_each_kind_of_error_by_hand():
    # told: blocked (false), moved, moved (false), blocked, moved
    said = answered(["blocked", "blocked", "blocked", "blocked", "moved"], false_at=[1, 3])
    found = misinterpretations([said])
    assert {(k.claimed, k.told, k.truth): k.count for k in found.counts if k.count} == {
        ("blocked", "blocked", "moved"): 1,  # a false report, believed
        ("blocked", "moved", "moved"): 1,  # a true report, misread
        ("blocked", "moved", "blocked"): 1,  # a false report, undone by a misreading
        ("blocked", "blocked", "blocked"): 1,
        ("moved", "moved", "moved"): 1,
    }
    assert (found.believed, found.misread, found.undone) == (1, 1, 1)
    assert (found.misinterpreted.count, found.falsely_told.count, found.false_belief.count) == (2, 2, 2)
    assert (found.moved_for_blocked.count, found.moved_for_blocked.n) == (0, 2)
    assert (found.blocked_for_moved.count, found.blocked_for_moved.n) == (2, 3)


@pytest.mark.parametrize("seed", range(3))
def test_the_three_errors_add_up(seed):
    found = misinterpretations(played(seed))
    assert len(found.counts) == 8
    assert sum(kind.count for kind in found.counts) == found.pooled.n
    assert found.misinterpreted.count == found.total == found.misread + found.undone
    assert found.falsely_told.count == found.believed + found.undone
    assert found.false_belief.count == found.against_truth.count == found.believed + found.misread
    assert found.moved_for_blocked.count + found.blocked_for_moved.count == found.total
    assert found.moved_for_blocked.n + found.blocked_for_moved.n == found.pooled.n


@pytest.mark.parametrize("seed", range(3))
def test_a_trial_is_what_its_claims_are(seed):
    trials = played(seed)
    rows = [trial_claims(trial) for trial in trials]
    found = misinterpretations(trials)
    rates = [row.rate for row in rows if row.rate is not None]
    assert (found.mean_rate, found.sd_rate) == (pytest.approx(np.mean(rates)), pytest.approx(np.std(rates, ddof=1)))
    assert found.affected == sum(row.misinterpreted > 0 for row in rows)
    assert found.false_belief.count == sum(row.false_beliefs for row in rows)
    assert found.falsely_told.count == sum(row.falsely_told for row in rows)
    assert (found.false_reports.count, found.false_reports.n) == (sum(row.false_reports for row in rows), 12 * 6)
    for trial, row in zip(trials, rows, strict=True):
        assert row.claims == tuple(claims(trial))
        assert row.false_reports == sum(step.told_moved != step.moved for step in trial.steps)


def test_claims_of_one_trial_are_not_independent():
    """All wrong in half of the trials and none in the others says less than as many wrong claims spread evenly."""
    right = ["moved", "moved", "blocked", "blocked"]
    wrong = ["blocked", "blocked", "moved", "moved"]
    half = [answered(right if number % 2 else wrong, trial=number) for number in range(1, 11)]
    spread = [answered([*right[:2], *wrong[2:]], trial=number) for number in range(1, 11)]
    together, apart = misinterpretations(half), misinterpretations(spread)
    assert together.misinterpreted.value == apart.misinterpreted.value == 0.5
    assert (together.affected, apart.affected) == (5, 10)
    assert together.pooled == apart.pooled
    width = [found.misinterpreted.high - found.misinterpreted.low for found in (together, apart)]
    assert width[0] > 1.5 * width[1]


def test_hallucinated_changes_are_a_share_of_what_was_misread():
    blocked_for_moved = make_trial([3, 2, 1, 0], claims=[None, "blocked", "moved", "moved"])
    moved_for_blocked = make_trial([0, 1, 2, 0], claims=[None, "moved", "moved", "blocked"], trial=2)
    found = misinterpretations([blocked_for_moved, moved_for_blocked]).hallucinated
    assert (found.count, found.n, found.clusters) == (2, 3, 2)
