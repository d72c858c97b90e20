"""The start and end times of the spans of a trial, from clock readings if there are any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Trial

__all__ = ["Clock", "Interval", "TrialTimes", "trial_times"]

Clock = Literal["recorded", "calls", "none"]
"""The source of durations: the clock reading of the trial, those of its model calls only, or none."""

_NANOSECONDS = 1_000_000_000

_NO_CLOCK = 1_000_000
"""Nanoseconds of a step without a clock reading."""


@dataclass(frozen=True, slots=True)
class Interval:
    """Start and end of a span, in nanoseconds since 1970-01-01 UTC."""

    start: int
    end: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialTimes:
    """The intervals of one trial.

    Attributes:
        trial: The whole trial.
        steps: Each step, in order; they follow each other without a gap.
        calls: Each model call, in the order in which the calls were given; each lies in its step.
        clock: The source of the durations.
    """

    trial: Interval
    steps: tuple[Interval, ...]
    calls: tuple[Interval, ...]
    clock: Clock


def trial_times(trial: Trial, calls: Sequence[Call], seconds: float | None, start: int) -> TrialTimes:
    """Intervals of a trial that starts at ``start`` (nanoseconds since 1970-01-01 UTC).

    A trial lasts as long as its clock reading (``seconds``) says, and at least as long as its calls. A step lasts as
    long as its calls; the rest of the trial is divided equally among its steps, because no step has a clock reading.
    A trial without any reading has steps of one millisecond. Calls after the last step, where a trial broke, follow it.
    """
    lengths = [_nanoseconds(call.seconds) for call in calls]
    known = sum(lengths)
    clock: Clock = "none" if seconds is None and not known else "calls" if seconds is None else "recorded"
    count = len(trial.steps)
    whole = _NO_CLOCK * max(count, 1) if clock == "none" else known
    whole = max(whole, known, 0 if seconds is None else _nanoseconds(seconds))
    share, left = divmod(whole - known, count) if count else (0, 0)
    at, steps = start, []
    begun: dict[int, Interval] = {}
    for place, step in enumerate(trial.steps):
        begins = at
        for i, call in enumerate(calls):
            if call.step == step.step:
                begun[i] = Interval(at, at := at + lengths[i])
        at += share + (place < left)
        steps.append(Interval(begins, at))
    for i in range(len(calls)):
        if i not in begun:
            begun[i] = Interval(at, at := at + lengths[i])
    return TrialTimes(
        trial=Interval(start, start + whole),
        steps=tuple(steps),
        calls=tuple(begun[i] for i in range(len(calls))),
        clock=clock,
    )


def _nanoseconds(seconds: float) -> int:
    return round(seconds * _NANOSECONDS)
