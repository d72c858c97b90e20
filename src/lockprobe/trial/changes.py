"""What interventions change: values passed from one to the next, and the steps at which each had an effect.

An intervention changes a step if it changed what it was given, and the agent would have got something else without it:
what no report shows, or a later intervention hides, is no change.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from lockprobe.trial.luck import Stream
from lockprobe.trial.places import whole

_One = TypeVar("_One")
_V = TypeVar("_V")


@dataclass(frozen=True, slots=True)
class Acting(Generic[_One]):
    """An intervention of a trial.

    Attributes:
        number: Its place in the condition, from 0.
        one: The intervention.
        luck: Its random stream.
    """

    number: int
    one: _One
    luck: Stream


class Passed(NamedTuple, Generic[_V]):
    """A value that has passed through interventions.

    Attributes:
        value: The value that came out.
        changed: The numbers of the interventions that changed it.
        differs: Whether it differs from the value that went in.
    """

    value: _V
    changed: tuple[int, ...]
    differs: bool


def pass_through(
    acting: Sequence[Acting[_One]],
    given: _V,
    apply: Callable[[Acting[_One], _V], _V],
    shown: Callable[[_V], object] = whole,
) -> Passed[_V]:
    """Pass a value through interventions, and find out which of them changed it.

    Args:
        acting: The interventions, in the order in which they act.
        given: The value before the first of them.
        apply: What one of them makes of a value.
        shown: The part of a value that the agent gets.
    """
    value = given
    changers: list[_Changer[_One, _V]] = []
    for one in acting:
        before, value = value, apply(one, value)
        if value is not before and whole(value) != whole(before):
            changers.append(_Changer(one, before))
    if not changers:
        return Passed(value, (), False)
    end = shown(value)
    changed = tuple(
        changer.acting.number
        for at, changer in enumerate(changers)
        if _shown_without(changer.before, changers[at + 1 :], apply, shown) != end
    )
    return Passed(value, changed, shown(given) != end)


class _Changer(NamedTuple, Generic[_One, _V]):
    """An intervention that changed a value, and the value before."""

    acting: Acting[_One]
    before: _V


def _shown_without(
    value: _V,
    later: Sequence[_Changer[_One, _V]],
    apply: Callable[[Acting[_One], _V], _V],
    shown: Callable[[_V], object],
) -> object:
    """What the agent would have got without an intervention: ``later`` act again, on the value before it.

    One that breaks needs what was changed before it.
    """
    try:
        for changer in later:
            value = apply(changer.acting, value)
        return shown(value)
    except Exception:  # noqa: BLE001  anybody's code runs here, and the trial has gone on without this
        return object()


class Changes:
    """Counts the steps of one trial that interventions changed.

    A report counts at the step whose decision it precedes: no agent reads the last one.

    Args:
        specs: The number of every intervention that has a spec -> the spec.

    Attributes:
        steps: Steps at which the agent was told, asked or remembered something else than without interventions, or
            another joint than the chosen one was attempted.
    """

    def __init__(self, specs: Mapping[int, str]) -> None:
        self.steps = 0
        self._specs = specs
        self._counts: Counter[int] = Counter()
        self._now: list[Passed[Any]] = []
        self._next: list[Passed[Any]] = []

    def note(self, passed: Passed[_V]) -> _V:
        """Note what was changed for the decision of this step, or for its attempt."""
        if passed.changed or passed.differs:
            self._now.append(passed)
        return passed.value

    def note_report(self, passed: Passed[_V]) -> _V:
        """Note what was changed in the report before the next decision."""
        if passed.changed or passed.differs:
            self._next.append(passed)
        return passed.value

    def begin(self) -> None:
        """The next decision is about to be asked for."""
        self._now, self._next = self._next, []

    def end(self) -> None:
        """The step of the last decision is over: count it."""
        if not self._now:
            return
        self.steps += any(passed.differs for passed in self._now)
        for number in {number for passed in self._now for number in passed.changed}:
            self._counts[number] += 1

    @property
    def by_intervention(self) -> Mapping[str, int]:
        """The spec of every intervention -> the number of steps that it changed."""
        return {name: self._counts[number] for number, name in self._specs.items()}
