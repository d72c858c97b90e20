"""Encodings of a trial's actions for the loop measures: symbols, letters or numbers."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue

if TYPE_CHECKING:
    from lockprobe.trial.record import Trial

__all__ = ["Codes", "Letters", "Symbol", "actions_of", "letters", "numbered", "refuse_nan", "symbols"]

Symbol = Literal["action", "action-outcome", "state-action"]
"""What has to come back for a trial to loop.

* ``action``: the joint. The paper's choice.
* ``action-outcome``: the joint, and whether it truly moved. What the agent was told may differ.
* ``state-action``: the true configuration before the step, and the joint. Such a loop has truly led nowhere.
"""

Codes = NDArray[np.int64]
"""Actions as numbers from 0 to 2**31 - 1, shape (n,)."""


def symbols(trial: Trial, symbol: Symbol) -> tuple[Hashable, ...]:
    """One symbol per step of a trial. Outcome and state are the true ones, never what the agent was told."""
    if symbol == "action":
        return tuple(step.joint for step in trial.steps)
    if symbol == "action-outcome":
        return tuple((step.joint, step.moved) for step in trial.steps)
    if symbol == "state-action":
        return tuple((step.state, step.joint) for step in trial.steps)
    raise BadValue("symbol", symbol, f"one of {', '.join(get_args(Symbol))}")


def actions_of(sequence: Sequence[Hashable] | NDArray[Any]) -> Sequence[Hashable]:
    """The trial as a sequence of plain Python values."""
    if not isinstance(sequence, np.ndarray):
        return sequence
    _refuse_batch(sequence)
    refuse_nan(sequence)
    actions: list[Hashable] = sequence.tolist()
    return actions


def _refuse_batch(sequence: NDArray[Any]) -> None:
    if sequence.ndim != 1:
        raise BadValue("sequence", sequence.shape, "an array of shape (n,)")


def refuse_nan(actions: Collection[Hashable] | NDArray[Any]) -> None:
    """Refuse actions that are not equal to themselves (NaN): their recurrence would depend on their storage."""
    if isinstance(actions, np.ndarray):
        found = actions.dtype.kind not in "iubUS" and bool((actions != actions).any())  # noqa: PLR0124
    else:
        found = any(action != action for action in actions)  # noqa: PLR0124
    if found:
        expected = "one action per step; give trials of different length as a list of sequences"
        raise BadValue("sequence", "NaN", expected)


class Letters(str):
    """A trial as :func:`letters` writes it, which is written no second time."""

    __slots__ = ()


def letters(sequence: Sequence[Hashable] | NDArray[Any]) -> Letters:
    """The trial as a string of one letter per action, whose searches run in C."""
    if isinstance(sequence, Letters):
        return sequence
    names: dict[Hashable, str] = {}
    text = Letters("".join([names.setdefault(action, chr(len(names))) for action in actions_of(sequence)]))
    refuse_nan(names)
    return text


def numbered(sequence: Sequence[Hashable] | NDArray[Any]) -> Codes:
    """The trial as numbers: equal numbers for equal actions."""
    if isinstance(sequence, str):
        return np.frombuffer(sequence.encode("utf-32-le", "surrogatepass"), np.uint32).astype(np.int64)
    array = _integers(sequence)
    if array is None:
        names = {action: number for number, action in enumerate(dict.fromkeys(sequence))}
        refuse_nan(names)
        return np.fromiter(map(names.__getitem__, sequence), np.int64, len(sequence))
    if len(array) and (array.min() < 0 or array.max() >= 2**31):
        array = np.unique(array, return_inverse=True)[1]
    return array.astype(np.int64, copy=False)


def _integers(sequence: Sequence[Hashable] | NDArray[Any]) -> NDArray[Any] | None:
    """The trial as an array of integers, if that is what its actions are."""
    if not isinstance(sequence, np.ndarray):
        if not (len(sequence) and isinstance(sequence[0], int)):
            return None
        try:
            sequence = np.array(sequence)
        except ValueError:  # numbers beside tuples
            return None
    _refuse_batch(sequence)
    return sequence if sequence.dtype.kind in "iub" else None
