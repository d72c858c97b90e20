"""The trials of one agent over the doses of one axis."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from math import nan
from typing import NamedTuple

from lockprobe.foundation.spec import spec_kind, spec_name
from lockprobe.statistics.outcomes import Outcomes, broken_off, ended, outcomes
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import Trial


class Place(NamedTuple):
    """The place of a trial on an axis.

    Attributes:
        agent: What tables call the agent whose course over the axis it belongs to, or several that differ in an option.
        modality: How the box is shown, without doses.
        dose: Its dose.
    """

    agent: str
    modality: str
    dose: float


def on_flip_axis(trial: Trial) -> Place:
    """Its place on the axis of flip rates; the dose is not a number if other interventions acted."""
    return Place(trial.group, trial.modality, nan if trial.p is None else trial.p)


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisTrials:
    """The trials of one agent, shown in one way, over the doses of one axis.

    Attributes:
        agent: What tables call it.
        modality: How the box is shown.
        trials: Its trials, by dose, repetition and trial.
        doses: The dose of each.
        orders: The order of its blocks, if what is said must hold at every look.
    """

    agent: str
    modality: str
    trials: tuple[Trial, ...]
    doses: tuple[float, ...]
    order: BlockOrder | None = None

    @property
    def kind(self) -> str:
        """The kind of the agent: ``random``, ``llm``, ``participant``."""
        return spec_kind(self.spec)

    @property
    def spec(self) -> str:
        """The spec of the agent, which names its random streams; of several that differ in an option, without options.

        A name changes no number.
        """
        specs = {trial.spec for trial in self.trials}
        return self.trials[0].spec if len(specs) == 1 else spec_name(self.trials[0].spec)

    @property
    def seed(self) -> int:
        """Seed of the study."""
        return self.trials[0].seed

    @property
    def budget(self) -> int:
        """Most steps of a trial."""
        return max(trial.budget for trial in self.trials)

    @property
    def outcomes(self) -> Outcomes:
        """Its ended trials as columns."""
        return outcomes(self.trials, self.doses, self.order)

    @property
    def broken_off(self) -> Outcomes:
        """Its trials that ended as error, up to the error."""
        return broken_off(self.trials, self.doses, self.order)

    @property
    def finished_doses(self) -> set[float]:
        """The doses at which a trial has ended."""
        finished = {id(trial) for trial in ended(self.trials)}
        return {dose for trial, dose in zip(self.trials, self.doses, strict=True) if id(trial) in finished}

    def by_dose(self) -> Iterator[tuple[float, list[Trial]]]:
        """Every dose with its trials, ascending."""
        pairs = zip(self.doses, self.trials, strict=True)
        for dose, members in groupby(pairs, key=lambda pair: pair[0]):
            yield dose, [trial for _, trial in members]

    def at(self, doses: Collection[float]) -> AxisTrials:
        """Its trials at these doses, of which it has at least one."""
        kept = [pair for pair in zip(self.trials, self.doses, strict=True) if pair[1] in doses]
        trials, found = zip(*kept, strict=True)
        return replace(self, trials=trials, doses=found)

    @property
    def lowest(self) -> AxisTrials:
        """Its trials at its lowest dose."""
        return self.at(self.doses[:1])


def on_axis(
    trials: Iterable[Trial],
    place: Callable[[Trial], Place] = on_flip_axis,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
) -> list[AxisTrials]:
    """The trials by agent and modality, in the order in which these come."""
    found: dict[tuple[str, str], list[tuple[float, Trial]]] = {}
    for trial in trials:
        agent, modality, dose = place(trial)
        found.setdefault((agent, modality), []).append((dose, trial))
    made = []
    for (agent, modality), members in found.items():
        members.sort(key=lambda pair: (pair[0], pair[1].repetition, pair[1].trial))
        doses, own = zip(*members, strict=True)
        order = orders.get(own[0].group)
        made.append(AxisTrials(agent=agent, modality=modality, trials=own, doses=doses, order=order))
    return made
