"""Courses: one agent, shown the box in one way, over the doses of one axis; what fits and tests over doses are of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE, spec_kind
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.conditions.axis_trials import AxisTrials, Place, on_axis, on_flip_axis
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.inference.trend import Resamples, resample
from lockprobe.statistics.outcomes import Outcomes, Point, heeded_at_most, points
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import PLAIN_WORDS, Trial

_BASELINES = ("random", "random-no-repeat", "round-robin", "human-inspired", "ideal-observer")
"""The kinds of agents that are baselines."""


def is_baseline(spec: str) -> bool:
    """Whether the agent of a spec is a baseline: a study of other agents too is not about it."""
    return spec_kind(spec) in _BASELINES


@dataclass(frozen=True, kw_only=True)
class Course:
    """One agent over the doses of one axis.

    Attributes:
        trials: All its trials.
        axis: The dose in which they differ.
        key: What the column ``axis`` of rows calls it.
        shown: What tells it apart from other courses of the agent, in words; empty if nothing has to.
        heeded: Upper 95 % bound of the share of reports that it acts on if it plays alike whatever it is told, or None.
        idle: Doses above the lowest at which nothing was changed, or no report was false. They are in no fit or test.
        family: How many agents are judged together with it, itself included.
    """

    trials: AxisTrials
    axis: Axis
    key: str
    shown: str
    heeded: float | None
    idle: frozenset[float]
    family: int

    @property
    def agent(self) -> str:
        """Its name, or its spec if it has none."""
        return self.trials.agent

    @property
    def modality(self) -> str:
        """How it was shown the box."""
        return self.trials.modality

    @property
    def baseline(self) -> bool:
        """Whether it is a baseline."""
        return is_baseline(self.trials.spec)

    @property
    def people(self) -> bool:
        """Whether it is people, whose trials are clustered by person."""
        return self.agent == PEOPLE

    @property
    def blind(self) -> bool:
        """Whether it plays alike whatever it is told, so that its doses are copies of each other."""
        return self.heeded is not None

    @cached_property
    def by_dose(self) -> Mapping[float, list[Trial]]:
        """Every dose with its trials, ascending."""
        return dict(self.trials.by_dose())

    @cached_property
    def tested(self) -> AxisTrials:
        """The trials that fits and tests use: at doses that acted, or at the lowest alone if it is blind."""
        doses = sorted(self.by_dose)
        return self.trials.at({doses[0]} if self.blind else {*doses} - self.idle)

    @cached_property
    def ended(self) -> Outcomes:
        """Those of them that ended as solved or out of budget."""
        return self.tested.outcomes

    @cached_property
    def broke(self) -> Outcomes:
        """Those of them that broke."""
        return self.tested.broken_off

    @cached_property
    def points(self) -> list[Point]:
        """Their shares by dose and repetition, which the paper's fits and its correlation are of."""
        return points(self.ended)

    @cached_property
    def draws(self) -> Resamples:
        """Bootstrap resamples of these points."""
        return resample(self.ended, self.stream("bootstrap"))

    def stream(self, use: str) -> np.random.Generator:
        """The random stream of a resampling test."""
        return generator(self.trials.seed, "analysis", self.trials.spec, self.modality, use)


def courses(
    trials: Iterable[Trial],
    axis: Axis = FLIPS,
    key: str = FLIPS.name,
    place: Callable[[Trial], Place] = on_flip_axis,
    *,
    several: bool = False,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
) -> tuple[Course, ...]:
    """The courses over an axis, in the order of the trials.

    Args:
        trials: Trials that lie on the axis.
        axis: The dose in which conditions differ.
        key: What the column ``axis`` of rows calls it.
        place: The place of a trial on it.
        several: Whether the study has the axis in several modalities, so that agents are named with theirs.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
    """
    agents = [
        (one, heeded_at_most(one.trials), (one.modality, is_baseline(one.spec)))
        for one in on_axis(trials, place, orders)
    ]
    times = Counter(one.agent for one, *_ in agents)
    sizes = Counter(family for one, heeded, family in agents if heeded is None and len(one.finished_doses) > 1)
    found = []
    for one, heeded, family in agents:
        named = several or times[one.agent] > 1 or one.modality not in PLAIN_WORDS
        found.append(
            Course(
                trials=one,
                axis=axis,
                key=key,
                shown=", ".join(filter(None, (spoken(one.modality) if named else "", axis.rest))),
                heeded=heeded,
                idle=frozenset(dose for dose, members in [*one.by_dose()][1:] if never_acted(members)),
                family=max(1, sizes[family]),
            )
        )
    return tuple(found)
