"""The numbers of the conditions beside a study's flip axis: each against its control, crossed ones, doses, causes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from operator import call
from types import MappingProxyType

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.left_out import of_whom, section
from lockprobe.foundation.parallel import Each
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.axis_trials import Place
from lockprobe.statistics.conditions.condition import ConditionSummary, condition_summary
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.series import Series
from lockprobe.statistics.contrast import Effect, Effects, against_control, idle_conditions
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.factorial import FactorialEffects, factorial_effects
from lockprobe.statistics.idle import Idle, Unheeded, unheeded
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.reference import Reference, reference_of
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.statistics.summary import StudySummary, summarise
from lockprobe.statistics.why.contrasts import Why, whys
from lockprobe.trial.record import Trial

_Cells = Mapping[tuple[str, str], Sequence[Trial]]
"""The trials of every agent under every condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionStudySummary:
    """The numbers of the conditions beside the flip axis.

    Each contrast belongs to one family. The doses of an axis against the control are a family of the axis
    (:func:`lockprobe.statistics.summary.summarise`), of flip rates and of every dose of another intervention with three
    levels or more; all other conditions against their control are one, here. So conditions beside an axis change no P
    value of it, and it none of theirs.

    Attributes:
        design: What differs between the conditions of the study.
        conditions: Every agent under every condition -> its numbers, under (agent, condition).
        effects: Every agent's other conditions against their control.
        on_axes: The same of the doses of every axis, as the axis has tested them.
        series: Conditions that differ in one dose alone, each with the numbers over that dose.
        whys: Of a study of controls: why false reports change each agent's success.
        factorials: What each factor of a factorial design does to each agent.
        reference: What blind agents and the shortest plan reach on the box.
        idle: Conditions, other than controls, in which nothing was changed, and interventions that changed nothing in a
            whole condition. No comparison has the former, and no interaction or series has either.
        unheeded: Conditions under which an agent chose as under the control, although steps were changed.
    """

    design: Design
    conditions: Mapping[tuple[str, str], ConditionSummary]
    effects: tuple[Effects, ...]
    on_axes: tuple[Effects, ...]
    series: tuple[tuple[Series, StudySummary], ...]
    whys: tuple[Why, ...]
    factorials: tuple[FactorialEffects, ...]
    reference: Reference
    idle: tuple[Idle, ...] = ()
    unheeded: tuple[Unheeded, ...] = ()

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents of the study."""
        return self.design.agents

    @property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about: those that are no reference, or all if all are."""
        return tuple(agent for agent in self.agents if not is_baseline(self.design.spec_of(agent))) or self.agents


def summarise_conditions(
    trials: Sequence[Trial],
    design: Design,
    flips: StudySummary,
    *,
    box: Lockbox,
    budget: int,
    each: Each = map,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
) -> ConditionStudySummary:
    """Compute the numbers of the conditions beside the flip axis.

    Args:
        trials: All trials of the study.
        design: Its design.
        flips: The numbers of its flip axis.
        box: Its box.
        budget: Most steps of a trial.
        each: A map function over agents, sequential or parallel.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
    """
    reference = reference_of(box, budget)
    known = {(one.agent, one.name): one for one in flips.conditions}
    cells = grouped(trials, lambda trial: (trial.group, trial.condition))
    jobs = {
        name: partial(_condition_if_possible, members, orders.get(name[0]))
        for name, members in cells.items()
        if name[1] not in design.axis
    }
    found = dict(zip(jobs, each(call, jobs.values()), strict=True))
    conditions = {name: one for name in cells if (one := known.get(name) or found.get(name)) is not None}
    own = {name: _Cell(tuple(cells[name]), orders.get(name[0])) for name in conditions}
    idle = idle_conditions(own, design)
    acting = {name: cells[name] for name in conditions if name not in _names(idle, whole=True)}
    series = tuple(dose_series(trials, design, box=box, each=each, idle=_names(idle), orders=orders, known=conditions))
    # the doses of every axis whose lowest level is the control, against it
    by_axis = (flips, *(summary for one, summary in series if one in design.other_axes))
    return ConditionStudySummary(
        design=design,
        conditions=conditions,
        effects=section("Every condition against the control", lambda: tuple(against_control(own, design)), tuple),
        on_axes=tuple(one for summary in by_axis for agent in summary.agents if (one := _axis_effects(agent))),
        series=series,
        whys=section("Why false reports change success", lambda: whys(cells, design, orders), tuple),
        factorials=section("Factors of a factorial design", lambda: tuple(factorial_effects(cells, design)), tuple),
        reference=reference,
        idle=tuple(one for one in idle if one.condition not in design.axis),
        unheeded=_unheeded(acting, design),
    )


@dataclass(frozen=True)
class _Cell:
    trials: tuple[Trial, ...]
    order: BlockOrder | None

    @cached_property
    def ended(self) -> Outcomes:
        return outcomes(self.trials, order=self.order)

    @cached_property
    def broke(self) -> Outcomes:
        return broken_off(self.trials, order=self.order)


def _condition_if_possible(trials: Sequence[Trial], order: BlockOrder | None) -> ConditionSummary | None:
    """One agent under one condition; None if what no other number replaces cannot be computed."""
    with of_whom(f"{trials[0].group} under {trials[0].condition}"):
        return section("All numbers", lambda: condition_summary(trials, _on_no_axis, order), lambda: None)


def _on_no_axis(trial: Trial) -> Place:
    return Place(trial.group, trial.modality, math.nan)


_Names = frozenset[tuple[str, str]]
"""Agents and conditions."""


def _unheeded(cells: _Cells, design: Design) -> tuple[Unheeded, ...]:
    """Conditions beside flip rates under which an agent played as under its control."""
    known = {arm.label for arm in design.arms} - design.axis - design.controls
    return tuple(
        one
        for (agent, label), members in cells.items()
        if label in known and (one := unheeded(members, cells.get((agent, design.control(label)), ())))
    )


def _names(idle: Sequence[Idle], *, whole: bool = False) -> _Names:
    """The conditions in which something changed nothing; with ``whole`` only those in which all of it did not."""
    return frozenset((one.agent, one.condition) for one in idle if not (whole and one.intervention))


def _axis_effects(found: AgentSummary) -> Effects | None:
    """The doses of an axis against the lowest one, with the P values of the axis; None if none was compared."""
    tested = found.inference.difference
    names = {one.dose: one.name for one in found.conditions}
    if not tested.at or tested.lowest is None or found.blind:
        return None
    return Effects(
        agent=found.agent,
        modality=found.modality,
        control=names[tested.lowest],
        effects=tuple(Effect(condition=names[one.dose], difference=one) for one in tested.at),
        agents=tested.agents,
        axis=found.axis.name,
    )


def dose_series(
    trials: Sequence[Trial],
    design: Design,
    *,
    box: Lockbox,
    each: Each,
    idle: frozenset[tuple[str, str]] = frozenset(),
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
    known: Mapping[tuple[str, str], ConditionSummary] = MappingProxyType({}),
) -> Iterator[tuple[Series, StudySummary]]:
    """The numbers over every other dose, and over options of agents under the first control.

    Args:
        trials: All trials of the study.
        design: Its design.
        box: Its box.
        each: A map function over agents, sequential or parallel.
        idle: Agents and conditions in which a dose changed nothing, which are in no series.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
        known: Results of agents under conditions that were computed before.
    """
    first, found = design.control(design.arms[0].label), []
    for series in design.series:
        if series.agent:
            members = [trial for trial in trials if trial.group in series.doses and trial.condition == first]
            found.append((series, members, partial(_by_option, series)))
            continue
        members = [
            trial
            for trial in trials
            if trial.condition in series.doses
            and not (series.doses[trial.condition] and (trial.group, trial.condition) in idle)
        ]
        found.append((series, members, partial(_by_condition, series)))
    for series, members, place in found:
        several = Counter(one.axis for one in design.series)[series.axis] > 1
        on_it = partial(summarise, axis=series.axis, place=place, one_of_several=several, known=known, orders=orders)
        make = partial(on_it, members, box, each=each)
        summary = section(f"Doses of {series.axis.name}", make if members else _nothing, _nothing)
        if summary is not None:
            yield series, summary


def _nothing() -> None:
    return None


def _by_condition(series: Series, trial: Trial) -> Place:
    """The place of a trial by the dose of its condition."""
    return Place(trial.group, series.modality, series.doses[trial.condition])


def _by_option(series: Series, trial: Trial) -> Place:
    """The place of a trial by an option of its agent."""
    return Place(series.agent, trial.modality, series.doses[trial.group])
