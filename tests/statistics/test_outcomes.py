"""Trials as columns: what the tests look at is what the records say."""

import numpy as np
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.statistics.loops import any_loop
from lockprobe.statistics.outcomes import onset, outcomes, solved_in_pairs


def test_columns_are_the_records():
    trials = play_study(small_study())
    found = outcomes(trials)
    assert found.length.tolist() == [len(trial.steps) for trial in trials]
    assert found.solved.tolist() == [trial.solved for trial in trials]
    assert found.looped.tolist() == [any_loop(trial.actions) for trial in trials]
    assert list(zip(found.dose, found.repetition, found.trial, strict=True)) == [
        (trial.p, trial.repetition, trial.trial) for trial in trials
    ]


def test_onset_is_the_step_that_completes_the_first_loop():
    assert onset(make_trial([0, 1, 2, 0, 1, 2])) == 6
    assert onset(make_trial([3, 3, 0, 1, 2, 0, 3, 1])) == 0
    assert onset(make_trial([3, 0, 1, 2, 3, 0, 1, 2])) == 7


def test_broken_trials_are_in_no_column():
    assert len(outcomes([make_trial([0], broken="model"), make_trial(SOLUTION)])) == 1
    assert len(outcomes([])) == 0


def test_pairs_are_trials_that_both_have():
    failed = (0,) * 20
    first = outcomes([make_trial(SOLUTION, trial=3), make_trial(failed, trial=1), make_trial(SOLUTION, trial=2)])
    second = outcomes([make_trial(SOLUTION, trial=1), make_trial(failed, trial=3), make_trial(failed, trial=4)])
    assert solved_in_pairs(first, second).tolist() == [[False, True], [True, False]]
    assert solved_in_pairs(first, second).dtype == np.bool_
    assert solved_in_pairs(first, outcomes([make_trial(SOLUTION, trial=3, repetition=2)])).shape == (0, 2)
