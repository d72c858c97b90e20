"""What interventions change: values passed from one to the next, and the steps at which each had an effect.

An intervention changes a step if those after it, acting without it and those before it, would have given something
else. So what a later one hides is no change, and a step that none changed is as in truth.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from lockprobe.interventions.catalogue import spec_of
from lockprobe.protocols import Intervention

if TYPE_CHECKING:
    import numpy as np

__all__ = ["Acting", "Changes", "Passed", "pass_through", "whole"]

_One = TypeVar("_One")
_V = TypeVar("_V")


@dataclass(frozen=True, slots=True)
class Acting(Generic[_One]):
    """An intervention of a trial.

    Attributes:
        number: Its place in the condition, from 0.
        one: The intervention.
        rng: Its random stream.
    """

    number: int
    one: _One
    rng: np.random.Generator


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


def whole(value: object) -> object:
    """All of a value, and its way to take a picture if it has one: equality leaves that out."""
    return value, getattr(value, "look", None)


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
    value, first, states = _run(acting, given, apply)
    if first is None:
        return Passed(value, (), False)
    before, changed, without, start = shown(given), [], value, 0
    while first is not None:
        result, number = without, acting[start + first].number
        start += first + 1
        without, first, states = _again(acting[start:], states, given, apply) if states else (given, None, [])
        if shown(result) != shown(without):
            changed.append(number)
    return Passed(value, tuple(changed), before != shown(value))


_Run = tuple[_V, int | None, list[Any]]
"""The value that came out; the place of the first intervention that changed it; the states of the streams after that
place, before they were drawn from."""


def _run(acting: Sequence[Acting[_One]], given: _V, apply: Callable[[Acting[_One], _V], _V]) -> _Run[_V]:
    value, first, states = given, None, []
    for place, one in enumerate(acting):
        if first is not None:
            states.append(one.rng.bit_generator.state)
        before, value = value, apply(one, value)
        if first is None and value is not before and whole(before) != whole(value):
            first = place
    return value, first, states


def _again(
    acting: Sequence[Acting[_One]], states: Sequence[Any], given: _V, apply: Callable[[Acting[_One], _V], _V]
) -> _Run[_V]:
    """Run interventions again without those before; afterwards their streams are where they are now.

    One that breaks needs what those before it do: then these changed something.
    """
    now = [one.rng.bit_generator.state for one in acting]
    for one, state in zip(acting, states, strict=True):
        one.rng.bit_generator.state = state
    try:
        return _run(acting, given, apply)
    except Exception:  # noqa: BLE001  anybody's code runs here, and the trial has gone on without this
        return given, None, []
    finally:
        for one, state in zip(acting, now, strict=True):
            one.rng.bit_generator.state = state


class Changes:
    """Counts the steps of one trial that interventions changed.

    A report counts at the step whose decision it precedes: no agent reads the last one.

    Args:
        interventions: Those of the trial, in order.

    Attributes:
        steps: Steps at which the agent was told, asked or remembered something else than without interventions, or
            another joint than the chosen one was attempted.
    """

    def __init__(self, interventions: Sequence[Intervention]) -> None:
        self.steps = 0
        self._names = _names(interventions)
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
        return {name: self._counts[number] for number, name in self._names.items()}


def _names(interventions: Sequence[Intervention]) -> dict[int, str]:
    """The number of every intervention that has a spec -> the spec, and how often it came before if it did."""
    seen: Counter[str] = Counter()
    names: dict[int, str] = {}
    for number, one in enumerate(interventions):
        if is_dataclass(one) and not getattr(one, "shows", False):
            spec = spec_of(one)
            seen[spec] += 1
            names[number] = spec if seen[spec] == 1 else f"{spec} ({seen[spec]})"
    return names
