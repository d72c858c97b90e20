"""What may come back in a loop: actions, actions with true outcomes, or true states with actions."""

import pytest
from builders import make_trial

from lockprobe.analysis.loops import any_loop, cover, symbols
from lockprobe.errors import BadValue


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
