"""Courses: one agent, shown the box in one way, over the doses of one axis; what fits and tests over doses are of."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE, spec_kind, spec_name
from lockprobe.statistics.design import FLIPS, Axis
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.outcomes import NO_ORDERS, BlockOrder, Outcomes, Point, outcomes, plays_alike, points
from lockprobe.statistics.trend import Quantity, resample
from lockprobe.trial.record import PLAIN_WORDS, Trial

_BASELINES = ("random", "random-no-repeat", "round-robin", "right-to-left", "human-inspired", "ideal-observer")
"""The kinds of agents that are baselines."""


def is_baseline(spec: str) -> bool:
    """Whether the agent of a spec is a baseline: a study of other agents too is not about it."""
    return spec_kind(spec) in _BASELINES


class Place(NamedTuple):
    """The place of a trial on an axis: to whose course it belongs, how the box is shown without doses, and its dose."""

    agent: str
    modality: str
    dose: float


def on_flip_axis(trial: Trial) -> Place:
    """Its place on the axis of flip rates; the dose is not a number if other interventions acted."""
    return Place(trial.group, trial.modality, nan if trial.p is None else trial.p)


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """One agent over the doses of one axis.

    Attributes:
        agent: What tables call it, or several that differ in the option that is the axis.
        modality: How the box is shown, without doses.
        trials: All its trials, by dose, repetition and trial.
        doses: The dose of each.
        axis: The dose in which they differ.
        key: What the column ``axis`` of rows calls it.
        several: Whether the study has the axis in several modalities, so that agents are named with theirs.
        order: The order of its blocks, if what is said must hold at every look.
        beside: All agents over the axis, itself included.
    """

    agent: str
    modality: str
    trials: tuple[Trial, ...]
    doses: tuple[float, ...]
    axis: Axis
    key: str
    several: bool
    order: BlockOrder | None
    beside: Sequence[Course] = field(repr=False)

    @cached_property
    def spec(self) -> str:
        """The spec of the agent, which names its random streams; of several that differ in an option, without options.

        A name changes no number.
        """
        specs = {trial.spec for trial in self.trials}
        return self.trials[0].spec if len(specs) == 1 else spec_name(self.trials[0].spec)

    @property
    def baseline(self) -> bool:
        """Whether it is a baseline."""
        return is_baseline(self.spec)

    @property
    def people(self) -> bool:
        """Whether it is people, whose trials are clustered by person."""
        return self.agent == PEOPLE

    @property
    def shown(self) -> str:
        """What tells it apart from other courses of the agent, in words; empty if nothing has to."""
        twice = sum(one.agent == self.agent for one in self.beside) > 1
        named = self.several or twice or self.modality not in PLAIN_WORDS
        return ", ".join(filter(None, (spoken(self.modality) if named else "", self.axis.rest)))

    @cached_property
    def by_dose(self) -> Mapping[float, list[Trial]]:
        """Every dose with its trials, ascending."""
        pairs = grouped(zip(self.doses, self.trials, strict=True), lambda pair: pair[0])
        return {dose: [trial for _, trial in members] for dose, members in pairs.items()}

    def at(self, doses: Collection[float]) -> Course:
        """Its trials at these doses, of which it has at least one."""
        kept = [(one, dose) for one, dose in zip(self.trials, self.doses, strict=True) if dose in doses]
        trials, found = zip(*kept, strict=True)
        return replace(self, trials=trials, doses=found)

    @cached_property
    def lowest(self) -> Course:
        """Its trials at its lowest dose."""
        return self.at(self.doses[:1])

    @cached_property
    def outcomes(self) -> Outcomes:
        """Its trials as columns."""
        return outcomes(self.trials, self.doses, self.order)

    @cached_property
    def acted(self) -> Mapping[tuple[float, int, int], tuple[str, ...] | None]:
        """Dose, repetition and trial -> its actions; None of trials that broke."""
        pairs = zip(self.doses, self.trials, strict=True)
        return {(dose, one.repetition, one.trial): None if one.error else one.actions for dose, one in pairs}

    @cached_property
    def blind(self) -> bool:
        """Whether it plays alike whatever it is told, so that its doses are copies of each other."""
        return plays_alike(self.trials)

    @cached_property
    def idle(self) -> frozenset[float]:
        """Doses above the lowest at which nothing was changed, or no report was false. They are in no fit or test."""
        return frozenset(dose for dose, members in [*self.by_dose.items()][1:] if never_acted(members))

    @cached_property
    def family(self) -> int:
        """How many agents are judged together with it, itself included: those whose success can depend on the dose."""
        alike = [one for one in self.beside if (one.modality, one.baseline) == (self.modality, self.baseline)]
        return max(1, sum(not one.blind and len({*one.outcomes.ended.dose.tolist()}) > 1 for one in alike))

    @cached_property
    def tested(self) -> Outcomes:
        """The trials that fits and tests use: at doses that acted, or at the lowest alone if it is blind."""
        if self.blind:
            return self.lowest.outcomes
        return self.at(self.by_dose.keys() - self.idle).outcomes if self.idle else self.outcomes

    @cached_property
    def points(self) -> list[Point]:
        """Their shares by dose and repetition, which the paper's fits and its correlation are of."""
        return points(self.tested.ended)

    @cached_property
    def draws(self) -> Mapping[Quantity, NDArray[np.float64]]:
        """Bootstrap resamples of these points."""
        return resample(self.tested.ended, self.stream("bootstrap"))

    def stream(self, use: str) -> np.random.Generator:
        """The random stream of a resampling test."""
        return generator(self.trials[0].seed, "analysis", self.spec, self.modality, use)


def courses(
    trials: Iterable[Trial],
    axis: Axis = FLIPS,
    key: str = FLIPS.name,
    place: Callable[[Trial], Place] = on_flip_axis,
    *,
    several: bool = False,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
) -> tuple[Course, ...]:
    """The courses over an axis, by agent and modality in the order of the trials, all of which lie on it.

    ``orders`` has the agents of which everything must hold at every look; the rest is as in :class:`Course`.
    """
    found: list[Course] = []
    for (agent, modality), members in grouped(((place(one), one) for one in trials), lambda one: one[0][:2]).items():
        members.sort(key=lambda one: (one[0].dose, one[1].repetition, one[1].trial))
        own = tuple(trial for _, trial in members)
        found.append(
            Course(
                agent=agent, modality=modality, trials=own, doses=tuple(at.dose for at, _ in members), axis=axis,
                key=key, several=several, order=orders.get(own[0].group), beside=found,
            )
        )  # fmt: skip
    return tuple(found)
