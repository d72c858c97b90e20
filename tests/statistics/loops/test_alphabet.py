"""What may come back in a loop: actions, actions with true outcomes, or true states with actions."""

import numpy as np
import pytest
from builders import make_trial

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import (
    any_loop,
    any_loop_batch,
    cover,
    measure,
    onset,
    onset_batch,
)
from lockprobe.statistics.loops.alphabet import symbols


def test_symbols_are_the_truth_step_by_step() -> None:
    trial = make_trial([0, 3, 3, 2], false_at=[1, 2])
    names = [step.joint for step in trial.steps]
    assert symbols(trial, "action") == tuple(names)
    assert symbols(trial, "action-outcome") == (
        (names[0], False),
        (names[1], True),
        (names[2], True),
        (names[3], False),
    )
    assert symbols(trial, "state-action") == tuple((step.state, step.joint) for step in trial.steps)
    assert [state for state, _ in symbols(trial, "state-action")] == ["0000", "0000", "0001", "0000"]


def test_what_was_told_changes_no_symbol() -> None:
    joints = [0, 1, 2, 0, 1, 2, 3, 2]
    for symbol in ("action", "action-outcome", "state-action"):
        assert symbols(make_trial(joints), symbol) == symbols(make_trial(joints, false_at=range(1, 9)), symbol)


def test_a_finer_symbol_finds_no_more_loops() -> None:
    stuck, getting_on = make_trial([0, 1, 2] * 3), make_trial([3, 0, 1, 2, 3, 0, 1, 2])
    for symbol in ("action", "action-outcome", "state-action"):
        assert cover(symbols(stuck, symbol)).share == 1.0
    loops = [any_loop(symbols(getting_on, symbol)) for symbol in ("action", "action-outcome", "state-action")]
    assert loops == [True, False, False]


def test_an_unknown_symbol_is_refused() -> None:
    with pytest.raises(BadValue, match="action-outcome"):
        symbols(make_trial([0]), "percept")


NAN = float("nan")


@pytest.mark.parametrize("length", [7, 5007])
@pytest.mark.parametrize("of_one", [cover, any_loop, onset])
def test_what_is_not_itself_is_no_action_in_any_container(of_one, length) -> None:
    numbers = [1.0, 2.0, NAN, 1.0, 2.0, NAN, *range(length - 6)]
    days = np.array(["NaT", *["2024-01-01"] * (length - 1)])
    kept = [numbers, tuple(numbers), np.array(numbers), np.array(numbers, dtype=object)]
    for sequence in [*kept, days.astype("datetime64[D]"), days.astype("datetime64[ns]")]:
        with pytest.raises(BadValue, match="sequence: got 'NaN', expected one action per step; give trials of"):
            of_one(sequence)
        with pytest.raises(BadValue, match="NaN"):
            of_one(sequence, min_length=length + 1)


def test_nor_in_many_trials_at_once() -> None:
    padded = [[1.0, 2.0, NAN, NAN], [1.0, 2.0, 3.0, 4.0]]
    for of_many in (measure, any_loop_batch, onset_batch):
        for sequences in (np.array(padded), np.array(padded).astype("datetime64[s]")):
            with pytest.raises(BadValue, match="trials of different length as a list"):
                of_many(sequences)
    with pytest.raises(BadValue, match="trials of different length as a list"):
        measure(padded)


def test_floats_are_actions_like_others() -> None:
    trial = [0.5, 1.5, 2.5] * 2
    assert cover(np.array(trial)) == cover(trial)
    assert measure(np.array([trial])).onset.tolist() == onset_batch(np.array([trial])).tolist() == [6]
