"""From an opened study to its numbers: what sections of a report make their rows from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from lockprobe.foundation.grouping import grouped
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import rules_broken_said
from lockprobe.report.rows import Curve, Estimate, Row
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import Course, Place, courses, is_baseline
from lockprobe.statistics.design import Design, Series, axis_key
from lockprobe.statistics.every_look import share_at_every_look
from lockprobe.statistics.idle import idle_interventions
from lockprobe.statistics.outcomes import BlockOrder, Outcomes, outcomes
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.rules import Rules
from lockprobe.statistics.trend import Trend
from lockprobe.statistics.two_lines import TwoLines
from lockprobe.studies.decisions import Answer, answers_by_agent
from lockprobe.studies.study import Study
from lockprobe.studies.study_design import design_of
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import Trial


@dataclass(frozen=True, kw_only=True)
class PlayedCell:
    """One agent under one condition: its trials by repetition and trial, broken ones too.

    ``order`` is that of its blocks, if what is said of it must hold at every look.
    """

    agent: str
    modality: str
    condition: str
    doses: dict[str, float]
    trials: tuple[Trial, ...]
    order: BlockOrder | None = None

    def estimate(self, quantity: str, value: float | None = None, **columns: Any) -> Estimate:
        """A row of this cell."""
        return Estimate(quantity=quantity, value=value, **self.of, **columns)

    def share(self, quantity: str, found: Proportion, **columns: Any) -> list[Estimate]:
        """The row of a share of this cell; none if it is a share of nothing."""
        return share_rows(quantity, found, **self.of, **columns)

    def curve(self, quantity: str, **columns: Any) -> Curve:
        """A curve of this cell."""
        return Curve(quantity=quantity, **self.of, **columns)

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


class Axed(NamedTuple):
    """Conditions that differ in one dose alone, or agents that differ in one option alone, with the agents over them.

    ``number`` says which it is of several axes of its name.
    """

    number: int
    series: Series
    courses: tuple[Course, ...]


def _place(series: Series, trial: Trial) -> Place:
    """The place of a trial by the option of its agent, or by the dose of its condition."""
    if series.agent:
        return Place(series.agent, trial.modality, series.doses[trial.group])
    return Place(trial.group, series.modality, series.doses[trial.condition])


BOUNDS = ("at least", "at most")
"""Parts of a share or a difference of trials some of which broke: what it is at least and at most, whatever became of
these."""


PERMUTED = "permutation within blocks, and interval"
"""The test of success where outcomes are exchanged between conditions; its interval has to exclude 0 too."""


def measured_row(quantity: str, found: Any, **columns: Any) -> Estimate:
    """The row of what statistics found: its value, interval, P value and sizes, as far as it has them."""
    return Estimate(quantity=quantity, **measured(found) | columns)


def measured(found: Any) -> dict[str, Any]:
    """The columns of what statistics found, as far as it has them."""
    own = ("value", "low", "high", "p_value", "n", "count", "clusters")
    return {name: getattr(found, name) for name in own if hasattr(found, name)}


def share_rows(quantity: str, found: Proportion, **columns: Any) -> list[Estimate]:
    """The row of a share with its interval; none if it is a share of nothing."""
    return [measured_row(quantity, found, **columns)] if found.n else []


def of_course(course: Course) -> dict[str, Any]:
    """The columns of a number over the doses of an agent."""
    return {"agent": course.agent, "modality": course.modality, "axis": course.key}


def fit_rows(quantity: str, fit: Trend, course: Course) -> Iterator[Row]:
    """The paper's second-order least-squares fit over repetitions, and where it turns."""
    of, n = of_course(course), len(course.points)
    yield Curve(quantity=quantity, **of, n=n, x=fit.dose, value=fit.value, low=fit.low, high=fit.high)
    if fit.turning is not None:
        yield Estimate(quantity=quantity, **of, of=fit.kind, value=fit.turning, unit="dose")


def two_lines_rows(what: str, found: TwoLines, course: Course) -> Iterator[Estimate]:
    """Where two lines meet and the shape that they show, and each of them."""
    of = of_course(course)
    if found.break_p is not None:
        shape = {"value": found.break_p, "unit": "dose", "note": found.direction or ""}
        yield measured_row("two_lines", found, **of, of=what, test="two lines", **shape)
    for name, line in (("first line", found.first), ("second line", found.second)):
        if line is not None:
            tested = {"value": line.z, "p_value": line.p_value, "unit": "z"}
            yield Estimate(quantity="two_lines", **of | tested, of=f"{what}, {name}")


@dataclass(frozen=True, kw_only=True)
class StudyNumbers:
    """A study as its questions read it: its trials by agent and condition, and by agent over the doses of an axis."""

    opened: OpenedStudy

    @property
    def study(self) -> Study:
        """The settings of the study."""
        return self.opened.study

    @cached_property
    def design(self) -> Design:
        """What differs between its conditions."""
        return design_of(self.study)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Those of its trials that numbers are of, by agent and condition."""
        return self.opened.analysed

    @cached_property
    def cells(self) -> tuple[PlayedCell, ...]:
        """Every agent under every condition that has trials: flip rates by course, ascending, then in plan order."""
        own = grouped(self.trials, lambda trial: (trial.group, trial.condition))
        on_axis = [(one.agent, trials[0].condition) for one in self.courses for trials in one.by_dose.values()]
        plan = product(self.study.labels, self.conditions)
        order = on_axis if self.study.of_flips else [name for name in plan if name in own]
        return tuple(
            PlayedCell(
                agent=agent,
                modality=own[agent, label][0].modality,
                condition=label,
                doses=dict(self.conditions[label].doses),
                trials=tuple(own[agent, label]),
                order=self.opened.orders.get(agent),
            )
            for agent, label in order
        )

    @cached_property
    def by_name(self) -> Mapping[tuple[str, str], PlayedCell]:
        """The same by agent and condition, as contrasts take them."""
        return {(cell.agent, cell.condition): cell for cell in self.cells}

    @cached_property
    def courses(self) -> tuple[Course, ...]:
        """Every agent over the flip rates, the truth among them; baselines too."""
        return courses(self.opened.flip_trials, orders=self.opened.orders)

    @cached_property
    def axes(self) -> tuple[Axed, ...]:
        """Every other dose, and options of agents, with the agents over them."""
        first, times = self.design.control(self.design.arms[0].label), Counter(one.axis for one in self.design.series)
        known, found = Counter[tuple[str, str, str, str, str]](), []
        for series in self.design.series:
            axis = series.axis
            own = [
                one
                for one in self.trials
                if (one.group in series.doses and one.condition == first if series.agent else self._acts(series, one))
            ]
            if own:
                name = axis.name, axis.options, axis.rest, series.modality, series.agent
                known[name] += 1
                key = axis_key(axis.name, axis.options, axis.rest, known[name])
                place, several = partial(_place, series), times[axis] > 1
                over = courses(own, axis, key, place, several=several, orders=self.opened.orders)
                found.append(Axed(known[name], series, over))
        return tuple(found)

    def _acts(self, series: Series, trial: Trial) -> bool:
        """Whether a trial has one of these doses, and it is the control or changed something."""
        dose = series.doses.get(trial.condition)
        return dose is not None and not (dose and trial.condition in self.idle.get(trial.group, ()))

    @property
    def dose_courses(self) -> tuple[Course, ...]:
        """Every agent over every other dose, and over options of agents; baselines too."""
        return tuple(one for axis in self.axes for one in axis.courses)

    @cached_property
    def idle(self) -> Mapping[str, frozenset[str]]:
        """Agent -> the conditions, no controls, in which an intervention changed nothing; they are on no other axis.

        A study of flip rates alone has none.
        """
        acting = {arm.label: arm.without() for arm in self.design.arms}
        found: dict[str, set[str]] = {}
        for cell in self.cells if not self.study.of_flips else ():
            if cell.condition not in self.design.controls and idle_interventions(cell.trials, acting[cell.condition]):
                found.setdefault(cell.agent, set()).add(cell.condition)
        return {agent: frozenset(names) for agent, names in found.items()}

    @cached_property
    def conditions(self) -> Mapping[str, Condition]:
        """The conditions of the study by name, in its order."""
        return {one.label: one for one in self.study.conditions}

    @cached_property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about: those that are no baselines, or all if all are."""
        specs = dict(zip(self.study.labels, self.study.agents, strict=True))
        played = dict.fromkeys(one.agent for one in self.courses) or specs
        return tuple(agent for agent in played if not is_baseline(specs.get(agent, agent))) or tuple(played)

    @cached_property
    def rules(self) -> Rules:
        """The rules of its boxes."""
        return Rules(*self.study.boxes)

    @cached_property
    def broken_rules(self) -> Mapping[tuple[str, str], tuple[int, int]]:
        """Agent and condition -> attempts that broke the rules of the box, and of how many."""
        return {(cell.agent, cell.condition): self.rules.broken(cell.trials) for cell in self.cells}

    @cached_property
    def broken_rules_said(self) -> str:
        """The same of all trials, in few words; empty if none did."""
        return rules_broken_said(*map(sum, zip(*self.broken_rules.values(), strict=True)))

    @cached_property
    def decisions(self) -> Mapping[str, tuple[Answer, ...]]:
        """Agent -> what is decided, of a study that stops when it is; empty for others."""
        return answers_by_agent(self.study, self.opened.trials) if self.study.until else {}
