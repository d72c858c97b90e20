"""Trials that broke: what they can have become, and what is known of a share or a difference whatever that is.

A trial that broke was begun, and nobody knows how it would have ended. Long trials break most easily and are seldom
solved, so those that remain are a biased sample. So a share lies between two bounds, with all broken trials unsolved
and with all solved, and its interval reaches from the low end of the one to the high end of the other (Horowitz and
Manski, Econometrica 1995). A difference has *opposed* bounds: those of one side solved and those of the other unsolved,
and the reverse. Of a trial that broke in step c it is known that it was not solved before.

In 13 worlds in which length, failure or success breaks trials, under one condition or both, the bounds of a share cover
in .962 or more and those of a difference find a false effect in at most .03 of studies, with 15 to 300 trials; shares
without the broken trials cover in as little as .00.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.outcomes import Outcomes, appended

_Found = TypeVar("_Found", bound=Any)
_Result = TypeVar("_Result")


def completed(counted: Outcomes, broken: Outcomes, soon: ArrayLike, budget: int = 0) -> Outcomes:
    """All begun trials, as if those that broke had gone on from their break.

    Args:
        counted: The ended trials.
        broken: Those that broke.
        soon: Which of these solved the box in the step in which they broke, and completed a loop if they had none; all
            others did neither in all of their budget. Shape (broken,), or one for all.
        budget: Steps of a trial, for what asks how long it took.
    """
    at_once = np.broadcast_to(np.asarray(soon, dtype=np.bool_), len(broken))
    ended = broken.length + 1
    return appended(
        counted,
        replace(
            broken,
            solved=at_once.copy(),
            length=np.where(at_once, ended, np.maximum(ended, budget)),
            onset=np.where(at_once & (broken.onset == 0), ended, broken.onset),
        ),
    )


def opposed(
    analyse: Callable[[list[Outcomes]], _Result],
    counted: Sequence[Outcomes],
    broken: Sequence[Outcomes],
    gains: Sequence[bool],
    budget: int = 0,
) -> tuple[_Result, _Result]:
    """An analysis of groups of trials at its low and at its high end, from the ended and the broken trials of each.

    ``gains`` says whether success of the group counts for the difference; that of the others counts against it.
    """
    trios = [*zip(counted, broken, gains, strict=True)]
    low, high = (
        analyse([completed(one, other, gain == soon, budget) for one, other, gain in trios]) for soon in (False, True)
    )
    return low, high


def bounded(found: _Found, low: _Found, high: _Found) -> _Found:
    """A difference without the broken trials, a data class, with what holds at both ends of what these can have become.

    The value stays. The interval reaches from the lowest to the highest of both ends, and of the value, which rests on
    fewer trials. The P value is the larger one, and 1 if the three differ in sign. What an end lacks is None.
    """
    lows, highs, tests = ([getattr(one, name) for one in (low, high)] for name in ("low", "high", "p_value"))
    alike = len({np.sign(one.value) for one in (found, low, high)}) == 1
    return replace(
        found,
        low=None if None in lows else min(found.value, *lows),
        high=None if None in highs else max(found.value, *highs),
        p_value=None if None in tests else max(tests) if alike else 1.0,
    )


def worst(found: _Found, ends: Sequence[_Found]) -> _Found:
    """A test without the broken trials, a data class with a direction, with the larger P value of all ends.

    It is 1 if the directions differ, and None if an end has none. Without ends no trial broke.
    """
    tests = [one.p_value for one in (*ends, found)]
    if not ends or None in tests:
        return replace(found, p_value=None) if ends else found
    alike = len({one.direction for one in (found, *ends)}) == 1
    return replace(found, p_value=max(tests[:-1]) if alike else 1.0)


def begun(counted: Outcomes, broken: Outcomes) -> tuple[Outcomes, NDArray[np.float64]]:
    """All begun trials, and 1 where one was solved, 0 where it was not, NaN where it broke, shape (trials,)."""
    every = appended(counted, broken)
    return every, np.where(np.arange(len(every)) < len(counted), every.solved, np.nan)
