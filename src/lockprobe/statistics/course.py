"""Cells, an agent under a condition, and courses: an agent, shown the box in one way, over the doses of one axis."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import spec_kind
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.design import FLIPS, Axis
from lockprobe.statistics.every_look import share_at_every_look
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.outcomes import (
    BlockOrder,
    Outcomes,
    Point,
    joined,
    never_acted,
    outcomes,
    plays_alike,
    points,
)
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.shape import Quantity, resample
from lockprobe.trial.record import PLAIN_WORDS, Trial

_BASELINES = ("random", "random-no-repeat", "round-robin", "right-to-left", "human-inspired", "ideal-observer")
"""The kinds of agents that are baselines."""


def is_baseline(spec: str) -> bool:
    """Whether the agent of a spec is a baseline: a study of other agents too is not about it."""
    return spec_kind(spec) in _BASELINES


@dataclass(frozen=True, kw_only=True, eq=False)
class Cell:
    """One agent under one condition.

    Attributes:
        doses: Those of the condition.
        trials: All its trials by repetition and trial, broken ones too.
        order: The order of its blocks, if what is said must hold at every look.
    """

    agent: str
    modality: str
    condition: str
    doses: dict[str, float]
    trials: tuple[Trial, ...]
    order: BlockOrder | None = None

    @cached_property
    def outcomes(self) -> Outcomes:
        """Its trials as columns."""
        return outcomes(self.trials, order=self.order)

    @cached_property
    def ended(self) -> Outcomes:
        """Those of them that ended as solved or out of budget."""
        return self.outcomes.ended

    @cached_property
    def success(self) -> Proportion:
        """The share solved, with an interval that holds whatever became of those that broke."""
        every, solved = self.outcomes, self.outcomes.known
        if self.order is None or every.crossed:
            return share_of(solved, every.player, every.luck, every.box)
        return share_at_every_look(solved[np.argsort(self.order.rank(every.repetition, every.trial))])

    @property
    def of(self) -> dict[str, Any]:
        """The columns that say of which cell a row is."""
        return {"agent": self.agent, "modality": self.modality, "condition": self.condition, "doses": self.doses}


def cells_of(trials: Iterable[Trial], orders: Mapping[str, BlockOrder] = {}) -> dict[tuple[str, str], Cell]:
    """Every agent under every condition that it has trials of; ``orders`` has the agents judged at every look."""
    found = {}
    for (agent, condition), own in grouped(trials, lambda one: (one.group, one.condition)).items():
        own.sort(key=lambda one: (one.repetition, one.trial))
        found[agent, condition] = Cell(
            agent=agent, modality=own[0].modality, condition=condition, doses=dict(own[0].doses), trials=tuple(own),
            order=orders.get(agent),
        )  # fmt: skip
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """One agent over the doses of one axis.

    Attributes:
        agent: What tables call it, or several that differ in the option that is the axis.
        modality: How the box is shown, without doses.
        by_dose: What it did at each dose, ascending.
        axis: The dose in which they differ.
        several: Whether the study has the axis in several modalities, so that agents are named with theirs.
        beside: All agents over the axis, itself included.
    """

    agent: str
    modality: str
    by_dose: Mapping[float, Cell]
    axis: Axis
    several: bool
    beside: Sequence[Course] = field(repr=False)

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """Its cells by dose."""
        return tuple(self.by_dose.values())

    @cached_property
    def doses(self) -> tuple[float, ...]:
        """Their doses."""
        return tuple(self.by_dose)

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """All its trials, by dose, repetition and trial."""
        return tuple(trial for cell in self.cells for trial in cell.trials)

    @property
    def order(self) -> BlockOrder | None:
        """The order of its blocks, if what is said must hold at every look."""
        return self.cells[0].order

    @property
    def of(self) -> dict[str, Any]:
        """The columns that say of which course a row is."""
        return {"agent": self.agent, "modality": self.modality, "axis": self.axis.key}

    @property
    def spec(self) -> str:
        """The spec of the agent; of the first of several that differ in the option that is the axis."""
        return self.trials[0].spec

    @property
    def baseline(self) -> bool:
        """Whether it is a baseline."""
        return is_baseline(self.spec)

    @property
    def shown(self) -> str:
        """What tells it apart from other courses of the agent, in words; empty if nothing has to."""
        twice = sum(one.agent == self.agent for one in self.beside) > 1
        named = self.several or twice or self.modality not in PLAIN_WORDS
        return ", ".join(filter(None, (spoken(self.modality) if named else "", self.axis.rest)))

    def at(self, doses: Collection[float]) -> Course:
        """Its trials at these doses, of which it has at least one."""
        return replace(self, by_dose={dose: cell for dose, cell in self.by_dose.items() if dose in doses})

    @cached_property
    def lowest(self) -> Course:
        """Its trials at its lowest dose."""
        return self.at(self.doses[:1])

    @cached_property
    def outcomes(self) -> Outcomes:
        """Its trials as columns."""
        return joined([cell.outcomes for cell in self.cells], self.doses)

    @cached_property
    def acted(self) -> Mapping[tuple[float, int, int], tuple[str, ...] | None]:
        """Dose, repetition and trial -> its actions; None of trials that broke."""
        pairs = ((dose, one) for dose, cell in self.by_dose.items() for one in cell.trials)
        return {(dose, one.repetition, one.trial): None if one.error else one.actions for dose, one in pairs}

    @cached_property
    def blind(self) -> bool:
        """Whether it plays alike whatever it is told, so that its doses are copies of each other."""
        return plays_alike(self.trials)

    @cached_property
    def idle(self) -> frozenset[float]:
        """Doses above the lowest at which nothing was changed, or no report was false. They are in no fit or test."""
        return frozenset(dose for dose, cell in [*self.by_dose.items()][1:] if never_acted(cell.trials))

    @cached_property
    def family(self) -> int:
        """How many agents are judged together with it, itself included: those whose success can depend on the dose."""
        alike = [one for one in self.beside if (one.modality, one.baseline) == (self.modality, self.baseline)]
        return max(1, sum(not one.blind and sum(len(cell.ended) > 0 for cell in one.cells) > 1 for one in alike))

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
        """The random stream of a resampling test, so that agents of identical play have one result."""
        return generator(self.trials[0].seed, "analysis", self.modality, use)


def _at_flip_rate(cell: Cell) -> tuple[str, str, float]:
    return cell.agent, cell.modality, cell.trials[0].p or 0.0


def courses(
    cells: Iterable[Cell],
    axis: Axis = FLIPS,
    place: Callable[[Cell], tuple[str, str, float] | None] = _at_flip_rate,
    *,
    several: bool = False,
) -> tuple[Course, ...]:
    """The courses over an axis, by agent and modality in the order of the cells.

    ``place`` says of a cell to whose course it belongs, how the box is shown without doses, and its dose; None if it is
    not on the axis. The rest is as in :class:`Course`.
    """
    found: list[Course] = []
    placed = ((at, cell) for cell in cells if (at := place(cell)))
    for (agent, modality), own in grouped(placed, lambda one: one[0][:2]).items():
        by_dose = {dose: cell for (*_, dose), cell in sorted(own, key=lambda one: one[0][2])}
        of: dict[str, Any] = {"agent": agent, "modality": modality, "axis": axis, "several": several}
        found.append(Course(by_dose=by_dose, beside=found, **of))  # beside is complete once all courses are made
    return tuple(found)
