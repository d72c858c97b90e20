"""Trials that share their luck are drawn together; the band covers about as often as it says."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from builders import SOLUTION, make_trial
from solved import study

from lockprobe.statistics.inference.trend import trend
from lockprobe.statistics.outcomes import Point, outcomes, points
from lockprobe.statistics.resample import drawn_shares, resample

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


PLAYED = {
    (solved, p): make_trial(joints, agent="x", p=p)
    for solved, joints in ((True, SOLUTION), (False, [0] * 4))
    for p in P7
}


def trials_of(solved):
    """Trials from an array (p, repetition, trial) of solved or not."""
    return [
        replace(PLAYED[bool(solved[i, r, t]), P7[i]], repetition=r + 1, trial=t + 1)
        for i in range(solved.shape[0])
        for r in range(solved.shape[1])
        for t in range(solved.shape[2])
    ]


def test_resamples_centre_on_the_points_with_the_spread_of_a_share():
    solved = np.random.default_rng(1).random((3, 2, 40)) < 0.3
    trials = trials_of(solved)
    shares = points(outcomes(trials))
    drawn = resample(outcomes(trials), np.random.default_rng(2)).success
    assert drawn.mean(axis=0) == pytest.approx([point.success for point in shares], abs=0.01)
    expected = [np.sqrt(point.success * (1 - point.success) / 40) for point in shares]
    assert drawn.std(axis=0) == pytest.approx(expected, rel=0.1)


def test_the_same_trial_at_another_p_is_drawn_with_it():
    solved = np.repeat(np.random.default_rng(1).random((1, 1, 30)) < 0.5, 2, axis=0)
    trials = trials_of(solved)
    drawn = resample(outcomes(trials), np.random.default_rng(2)).success
    assert np.array_equal(drawn[:, 0], drawn[:, 1])


def test_a_repetition_of_one_trial_cannot_be_resampled():
    trials = trials_of(np.ones((3, 2, 1), dtype=bool))
    assert resample(outcomes(trials), np.random.default_rng(2)).success.shape == (0, 6)


def test_the_band_of_the_papers_design_covers_about_as_often_as_it_says(monkeypatch):
    """7 p x 3 repetitions x 10 trials, nothing depends on p: the band should hold the truth in 95 % of studies.

    With 400 resamples a study its ends move by about 3 % of its width.
    """
    monkeypatch.setattr("lockprobe.statistics.resample.drawn_shares", partial(drawn_shares, resamples=400))
    rng = np.random.default_rng(3)
    held = []
    for _ in range(60):
        solved = rng.random((7, 3, 10)) < 0.5
        shares = [
            Point(dose=P7[i], repetition=r + 1, n=10, success=float(solved[i, r].mean()), loop_rate=0.0)
            for i in range(7)
            for r in range(3)
        ]
        fit = trend(shares, "success", resample(study(solved), rng).success)
        middle = len(fit.dose) // 2
        held.append(fit.low[middle] <= 0.5 <= fit.high[middle])
    assert np.mean(held) > 0.95 - 4 * np.sqrt(0.95 * 0.05 / 60)
