"""Measures of single trials, most of them of packages, and their means over the trials of a condition.

An installed package adds a measure by an entry point of its name in the group
``lockprobe.measures``; ``python:module:name?option=value`` names a function directly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import Literal

import numpy as np

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import Plugin, allow, find_plugin, first_line, is_own_function, plugin_names
from lockprobe.foundation.spec import Spec, arguments_from
from lockprobe.statistics.clustered import clustered_variance, share_of, student
from lockprobe.statistics.outcomes import ended, outcomes
from lockprobe.statistics.proportions import Difference
from lockprobe.trial.record import Trial

Measure = Callable[[Trial], float | bool | None]
"""A trial -> a number, yes or no, or None where it does not apply."""


def _solved(trial: Trial) -> bool:
    """Whether the target moved within the budget."""
    return trial.solved


MEASURES: Mapping[str, Measure] = {"solved": _solved}
"""Those that ship by name; what else Lockprobe measures has rows in every report."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedMeasure:
    """A measure with the spec by which users call it, the first line of its description, and its origin elsewhere."""

    name: str
    what: str
    of: Measure
    plugin: Plugin | None = None

    def __call__(self, trial: Trial) -> float | bool | None:
        """The measure of one trial; refused unless it is a finite number, True, False or None."""
        with self.plugin.guarded() if self.plugin else nullcontext():
            value = self.of(trial)
        if value is None or isinstance(value, bool | np.bool_):
            return None if value is None else bool(value)
        if not isinstance(value, int | float | np.number) or not math.isfinite(value):
            raise BadValue(f"measure {self.name}", value, "a finite number, True, False or None")
        return float(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """The mean of one measure over some trials, with its interval. Error trials are left out.

    Attributes:
        kind: ``share`` for a yes or no; ``mean`` for a number.
        n: Trials to which it applies.
        left_out: Ended trials (solved or out of budget) to which it does not apply.
        value: The mean over the ``n`` trials; None without one.
        low, high: Ends of its 95 % interval: for a share as that of success; for a mean Student's t over clusters.
            None for a mean with fewer than two clusters, or if all values are equal.
    """

    name: str
    what: str
    kind: Literal["share", "mean"]
    n: int
    left_out: int
    value: float | None
    low: float | None
    high: float | None


def find_measure(measure: str | Measure) -> NamedMeasure:
    """The measure that a spec names, or a function of a trial as one.

    A spec is a name or ``python:module:name?option=value``. Options are further arguments of the function.
    """
    if not isinstance(measure, str):
        name = getattr(measure, "__name__", type(measure).__name__)
        return NamedMeasure(name=name, what=first_line(measure), of=measure)
    spec = Spec.parse(measure, "measure")
    name, options = spec.full_name, spec.options
    if name in MEASURES:
        if options:
            raise BadValue("measure", measure, f"{name} without options")
        return NamedMeasure(name=name, what=first_line(MEASURES[name]), of=MEASURES[name])
    allow(measure)
    if (plugin := find_plugin("measure", measure)) is None:
        raise UnknownName("measure", name, [*MEASURES, *plugin_names("measure")])
    found = plugin.load()
    if not is_own_function(found):
        raise BadValue("measure", measure, "a function of a trial")
    with plugin.guarded():  # options are the arguments after the first, the trial
        own = arguments_from(found, plugin.name, options, list(signature(found).parameters)[:1]) if options else {}
    made = partial(found, **own) if own else found
    return NamedMeasure(name=measure, what=first_line(found), of=made, plugin=plugin)


def measured(trials: Sequence[Trial], measure: NamedMeasure) -> Measured:
    """The mean of a measure over trials of an agent under a condition, with a 95 % interval.

    People's trials are clustered by person and by luck.
    """
    trials = ended(trials)
    found = [(trial, value) for trial in trials if (value := measure(trial)) is not None]
    kinds = {isinstance(value, bool) for _, value in found}
    if len(kinds) > 1:
        raise BadValue(f"measure {measure.name}", [value for _, value in found][:4], "numbers, or True and False")
    share, n, mean = kinds == {True}, len(found), Difference(value=math.nan)
    if found:
        of, values = outcomes([trial for trial, _ in found]), np.array([value for _, value in found], dtype=np.float64)
        mean = Difference(value=float(values.mean()))
        clusters = (of.player, of.luck) if of.crossed else (of.luck,)
        fewest = min(len(np.unique(kind)) for kind in clusters)
        if share:
            counted = share_of(values, of.player, of.luck, of.box)
            mean = Difference(value=counted.value, low=counted.low, high=counted.high)
        elif fewest > 1 and np.ptp(values):
            mean = student(mean, clustered_variance(values - mean.value, *clusters) / n**2, fewest)
    return Measured(
        name=measure.name, what=measure.what, kind="share" if share else "mean", n=n, left_out=len(trials) - n,
        value=mean.value if found else None, low=mean.low, high=mean.high,
    )  # fmt: skip
