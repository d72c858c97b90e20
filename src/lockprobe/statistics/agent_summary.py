"""The results of one agent over the doses of one axis: its conditions, fits and tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from lockprobe.foundation.left_out import section
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.conditions.axis_trials import AxisTrials, Place
from lockprobe.statistics.conditions.condition import ConditionSummary, Contrast, condition_at, contrast
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.infer import Inference, infer
from lockprobe.statistics.inference.trend import TrendFit, trend_fit
from lockprobe.statistics.outcomes import Point, outcomes
from lockprobe.statistics.resample import resample
from lockprobe.trial.record import PLAIN_WORDS, Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSummary:
    """The results of one agent in one modality over all doses of one axis.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        shown: The modality (unless it is the default and the only one) and ``axis.rest``, in words.
        reference: Whether it is a baseline.
        heeded: Upper 95 % bound of the share of reports that it acts on if it plays alike whatever it is told, or None.
        conditions: The results by dose, ascending. Those that never acted are in no fit, test or contrast.
        success_fit: Trend of success over p (Fig. 4).
        inference: The tests.
        contrast: The lowest p against the p that differs most clearly; None with one p, or if blind.
        axis: The dose in which its conditions differ.
        spec: The spec of the agent; of several that differ in an option, without options.
    """

    agent: str
    modality: str
    shown: str
    reference: bool
    heeded: float | None
    conditions: tuple[ConditionSummary, ...]
    success_fit: TrendFit
    inference: Inference
    contrast: Contrast | None
    axis: Axis = FLIPS
    spec: str = ""

    @property
    def name(self) -> str:
        """What tables call it, and ``shown`` in brackets."""
        return f"{self.agent} ({self.shown})" if self.shown else self.agent

    @property
    def idle(self) -> tuple[ConditionSummary, ...]:
        """Its conditions above the lowest dose under which nothing was changed, or no report was false."""
        return tuple(one for one in self.conditions[1:] if one.never_acted)

    @property
    def blind(self) -> bool:
        """Whether it plays alike whatever it is told, so that its conditions are copies of each other."""
        return self.heeded is not None

    @property
    def invited(self) -> bool:
        """Whether it is people, who are invited rather than run; their trials are clustered by person."""
        return self.agent == PEOPLE

    @property
    def points(self) -> tuple[Point, ...]:
        """All repetitions of all its conditions."""
        return tuple(point for condition in self.conditions for point in condition.points)


def agent_summary(
    trials: AxisTrials,
    axis: Axis,
    place: Callable[[Trial], Place],
    known: Mapping[tuple[str, str], ConditionSummary],
    *,
    several: bool,
    heeded: float | None,
    agents: int,
) -> AgentSummary:
    """The results of one agent in one modality.

    Args:
        trials: Its trials.
        axis: The dose in which conditions differ.
        place: The place of a trial on the axis.
        known: Results under conditions that were computed before, of the same trials.
        several: Whether other trials of it have another modality.
        heeded: As in :class:`AgentSummary`.
        agents: Agents that are judged together.
    """
    conditions = tuple(condition_at(members, place, known, trials.order) for _, members in trials.by_dose())
    acting = (conditions[0], *(one for one in conditions[1:] if not one.never_acted))
    distinct = acting if heeded is None else conditions[:1]
    shares = [point for condition in distinct for point in condition.points]
    looked_at = trials.at({condition.dose for condition in distinct})
    inference = _tested(looked_at, trials.budget, agents)
    shown = spoken(trials.modality) if several or trials.modality not in PLAIN_WORDS else ""
    return AgentSummary(
        agent=trials.agent,
        spec=trials.spec,
        modality=trials.modality,
        shown=", ".join(filter(None, (shown, axis.rest))),
        reference=is_baseline(trials.spec),
        heeded=heeded,
        conditions=conditions,
        **_fits(shares, looked_at),
        inference=inference,
        contrast=section(
            "Clearest difference",
            lambda: contrast(conditions, inference.difference) if heeded is None else None,
            lambda: None,
        ),
        axis=axis,
    )


def _tested(trials: AxisTrials, budget: int, agents: int) -> Inference:
    """The tests of one agent's trials; without a result if they cannot be made."""
    return section(
        "Hypothesis tests",
        lambda: infer(
            trials.outcomes,
            _stream(trials, "permutation"),
            broken=trials.broken_off,
            budget=budget,
            agents=agents,
        ),
        lambda: infer(outcomes(()), _stream(trials, "permutation"), agents=agents),
    )


class _Fits(TypedDict):
    """The curves over the dose, as fields of :class:`AgentSummary`."""

    success_fit: TrendFit


def _fits(shares: Sequence[Point], trials: AxisTrials) -> _Fits:
    """The curves over the dose; those that cannot be fitted are fits of no trials."""
    counted, none, empty = trials.outcomes, outcomes(()), np.empty((0, 0))
    draws = section(
        "Bootstrap of the trend",
        lambda: resample(counted, _stream(trials, "bootstrap")),
        lambda: resample(none, _stream(trials, "bootstrap")),
    )
    return _Fits(
        success_fit=section(
            "Trend of success",
            lambda: trend_fit(shares, "success", draws.success),
            lambda: trend_fit((), "success", empty),
        ),
    )


def _stream(trials: AxisTrials, use: str) -> np.random.Generator:
    return generator(trials.seed, "analysis", trials.spec, trials.modality, use)
