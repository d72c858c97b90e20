"""A misinterpretation contradicts what was told; contradicting the truth is counted apart."""

import pytest
from builders import make_trial

from lockprobe.analysis.misinterpretation import claims, misinterpretations


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


def test_without_claims_there_is_no_rate():
    found = misinterpretations([make_trial([3, 2, 1])])
    assert (found.trials, found.total, found.mean_rate, found.sd_rate) == (0, 0, None, None)
    assert found.pooled.n == 0
