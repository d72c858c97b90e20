"""Measures: their intervals held against those of the analysis, and what is no measure refused."""

import math

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.statistics.loops import onset
from lockprobe.statistics.measures import find_measure, measured
from lockprobe.statistics.proportions import proportion
from lockprobe.trial.record import Trial


def mean(trials, measure):
    return measured(trials, find_measure(measure))


def steps_to_solve(trial):
    """Steps until the target moved."""
    return len(trial.steps) if trial.solved else None


def test_shares_of_one_condition_have_the_intervals_of_the_report():
    trials = [trial for trial in play_study(small_study(["random"], p=[0.3], trials=9)) if trial.p == 0.3]
    loops = mean(trials, lambda trial: onset(trial.actions) > 0)
    expected = proportion(sum(onset(trial.actions) > 0 for trial in trials), 18)
    assert (loops.kind, loops.n, loops.left_out) == ("share", 18, 0)
    assert (loops.value, loops.low, loops.high) == (expected.value, expected.low, expected.high)


def test_means_have_student_s_interval_over_trials_or_over_luck():
    trials = play_study(small_study(["random"], p=[0.0], trials=9))
    lengths = np.array([len(trial.steps) for trial in trials])
    alone = mean(trials, lambda trial: float(len(trial.steps)))
    error = lengths.std(ddof=1) / math.sqrt(18)
    assert (alone.kind, alone.value) == ("mean", pytest.approx(lengths.mean()))
    assert (alone.high - alone.value) / error == pytest.approx(2.1098156)  # Student's t, 17 degrees of freedom
    assert alone.value - alone.low == pytest.approx(alone.high - alone.value)
    twice = mean(trials * 2, lambda trial: float(len(trial.steps)))
    assert twice.n == 36
    assert twice.high - twice.low == pytest.approx(alone.high - alone.low)  # the same luck again tells nothing new


def test_error_trials_are_left_out_and_what_does_not_apply_is_counted():
    trials = [make_trial(SOLUTION), make_trial([0] * 20, trial=2), make_trial([0], trial=3, broken="model")]
    steps = mean(trials, steps_to_solve)
    assert (steps.n, steps.left_out, steps.value, steps.low, steps.high) == (1, 1, 4.0, None, None)
    nothing = mean(trials[1:], steps_to_solve)
    assert (nothing.n, nothing.left_out, nothing.value) == (0, 1, None)
    same = mean([make_trial(SOLUTION, trial=n) for n in range(1, 9)], steps_to_solve)
    assert (same.value, same.low, same.high) == (4.0, None, None)  # nothing is known of their spread
    solved = mean(trials, "solved")
    assert (solved.name, solved.kind, solved.value, solved.n) == ("solved", "share", 0.5, 2)


def mixed(trial: Trial) -> float | bool:
    """A number of one trial, and yes or no of another."""
    return trial.solved if trial.trial == 1 else 0.5


def test_what_is_no_measure_is_refused():
    trials = [make_trial(SOLUTION), make_trial(SOLUTION, trial=2)]
    with pytest.raises(UnknownName, match=r"no measure is called 'solve' \(did you mean 'solved'\?\)"):
        mean(trials, "solve")
    with pytest.raises(BadValue, match="^measure mixed: got .*, expected numbers, or True and False$"):
        mean(trials, mixed)
    for value in (math.nan, math.inf, "four", [1]):
        with pytest.raises(BadValue, match="expected a finite number, True, False or None"):
            mean(trials, lambda trial: value)  # noqa: B023
    assert mean(trials, lambda trial: np.bool_(True)).kind == "share"
    assert mean(trials, lambda trial: np.int64(2)).value == 2
