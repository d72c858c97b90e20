"""The contract test of a measure."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.statistics.measures import Measure, find_measure, measured
from lockprobe.testing.trials import make_trial, play_trials
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_to_json


def check_measure(measure: str | Measure, *, trials: Sequence[Trial] = ()) -> None:
    """Check that a measure fulfils its contract.

    For any trial, also one that broke before its first step, it returns a finite number, a bool, or None. It never
    mixes numbers and bools. It returns the same value again and leaves the trial unchanged. It applies to at least one
    trial.

    Args:
        measure: Its spec, or the function.
        trials: Further trials; two agents always play true, false and missing reports.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
        UserMistake: If it is not a measure, or returns an invalid value.
    """
    found = find_measure(measure)
    every = [*trials, *_various()]
    before = [trial_to_json(trial) for trial in every]
    values = [found(trial) for trial in every]
    assert [found(trial) for trial in every] == values, f"{found.name} is another number when it is asked for again"
    assert [trial_to_json(trial) for trial in every] == before, f"{found.name} changes the trial"
    assert any(value is not None for value in values), f"{found.name} applies to no trial"
    kinds = {type(value) for value in values if value is not None}
    assert len(kinds) == 1, f"{found.name} is a number of one trial, and yes or no of another"
    measured(every, [found])


_CONDITIONS = ("truth", "flip?p=0.4", "drop?p=1", "tremble?p=0.5")


def _various() -> list[Trial]:
    played = [
        trial
        for agent in ("random", "human-inspired")
        for condition in _CONDITIONS
        for trial in play_trials(agent, 3, condition=condition)
    ]
    return [*played, make_trial((), broken=True), make_trial((0, 1), broken=True), make_trial((3,))]
