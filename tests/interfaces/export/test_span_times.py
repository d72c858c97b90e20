"""Spans lie in each other and last as long as the clock says."""

import pytest
from builders import SOLUTION, make_trial

from lockprobe.interfaces.export.span_times import trial_times
from lockprobe.trial.model_call import Call

SECOND = 10**9


def call(step, seconds, turn=1):
    return Call(key="k", step=step, turn=turn, request="r", reply="A", seconds=seconds)


def test_times_by_hand():
    times = trial_times(make_trial(SOLUTION), [call(1, 1.0), call(3, 2.0), call(3, 1.0, 2)], 8.0, 5)
    assert [(step.start - 5, step.end - 5) for step in times.steps] == [
        (0, 2 * SECOND),
        (2 * SECOND, 3 * SECOND),
        (3 * SECOND, 7 * SECOND),
        (7 * SECOND, 8 * SECOND),
    ]
    assert [(one.start - 5, one.end - 5) for one in times.calls] == [
        (0, SECOND),
        (3 * SECOND, 5 * SECOND),
        (5 * SECOND, 6 * SECOND),
    ]
    assert times.clock == "recorded"


@pytest.mark.parametrize("seconds", [None, 0.0, 0.5, 3.3333333])
@pytest.mark.parametrize("calls", [[], [call(1, 0.1), call(4, 0.7)], [call(9, 0.2)]])
def test_every_span_lies_in_the_trial_and_steps_follow_each_other(seconds, calls):
    times = trial_times(make_trial(SOLUTION), calls, seconds, 0)
    at = 0
    for step in times.steps:
        assert step.start == at <= step.end
        at = step.end
    assert all(at <= times.trial.end for at in [at, *(one.end for one in times.calls)])
    assert times.trial.end >= sum(round(one.seconds * SECOND) for one in calls)


def test_without_a_clock_a_step_lasts_a_millisecond():
    times = trial_times(make_trial(SOLUTION), [], None, 0)
    assert (times.clock, times.trial.end) == ("none", 4_000_000)
