"""Response times of people: medians and quartiles, since times are skewed to the right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lockprobe.statistics.outcomes import conditions_played, ended
from lockprobe.trial.record import Trial

__all__ = ["ResponseTimes", "response_times"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseTimes:
    """Response times under one condition, or in one modality over all conditions.

    Attributes:
        modality: How the box was shown.
        condition: Label of the condition; empty for all together.
        choices: Number of choices with a time.
        low, median, high: Quartiles, ms.
        first: Median of the first choices of boxes, which include looking at the panel, ms; None without any.
    """

    modality: str
    condition: str
    choices: int
    low: float
    median: float
    high: float
    first: float | None


def response_times(trials: Sequence[Trial], times: Mapping[tuple[str, int], float]) -> tuple[ResponseTimes, ...]:
    """Response times of people for each modality: by condition, then over all of them if there are several.

    Args:
        trials: The trials of one study; agents' trials and errors are left out.
        times: (Key of the trial, step from 1) -> time in ms.
    """
    own = [trial for trial in ended(trials) if trial.player]
    found = []
    for modality in dict.fromkeys(trial.modality for trial in own):
        shown = [trial for trial in own if trial.modality == modality]
        labels = conditions_played(shown)
        for condition in (*labels, *([""] if len(labels) > 1 else [])):
            members = [trial for trial in shown if condition in ("", trial.condition)]
            choices = {
                (trial.key, step.step): times[trial.key, step.step]
                for trial in members
                for step in trial.steps
                if (trial.key, step.step) in times
            }
            if choices:
                found.append(_at(modality, condition, choices))
    return tuple(found)


def _at(modality: str, condition: str, choices: Mapping[tuple[str, int], float]) -> ResponseTimes:
    low, median, high = np.quantile(list(choices.values()), (0.25, 0.5, 0.75))
    first = [time for (_, step), time in choices.items() if step == 1]
    return ResponseTimes(
        modality=modality,
        condition=condition,
        choices=len(choices),
        low=float(low),
        median=float(median),
        high=float(high),
        first=float(np.median(first)) if first else None,
    )
