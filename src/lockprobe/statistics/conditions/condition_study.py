"""The numbers of the conditions beside a study's flip axis: each against its control, crossed ones, doses, causes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import call
from types import MappingProxyType

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.left_out import of_whom, section
from lockprobe.foundation.parallel import Each
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.behaviour import heeded_at_most
from lockprobe.statistics.conditions.agents_by_condition import ComparisonUnder, agents_by_condition
from lockprobe.statistics.conditions.axis_trials import Place
from lockprobe.statistics.conditions.condition import ConditionSummary, condition_summary
from lockprobe.statistics.conditions.design import Comparison, Design
from lockprobe.statistics.conditions.effects import CONDITIONS, CONTROLS, Effect, Effects, effects
from lockprobe.statistics.conditions.factors import Factor, factor_effects
from lockprobe.statistics.conditions.no_feedback import no_feedback_factors
from lockprobe.statistics.conditions.series import Series
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.factorial.design import factorials_of
from lockprobe.statistics.factorial.effects import FactorialEffects, factorial_effects
from lockprobe.statistics.idle import Idle, Unheeded, idle_interventions, unheeded
from lockprobe.statistics.reference import Reference, reference_of
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.statistics.summary import StudySummary, summarise
from lockprobe.statistics.why.contrasts import Why, why
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
        on_factors: Conditions that differ in one option that is no number, against its first level.
        against_none: False reports against no feedback at all.
        agents_compared: Every two agents under each condition that is no flip rate.
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
    on_factors: tuple[Effects, ...]
    against_none: tuple[Effects, ...]
    agents_compared: tuple[ComparisonUnder, ...]
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
        name: partial(_condition_if_possible, members, reference, box, orders.get(name[0]))
        for name, members in cells.items()
        if name[1] not in design.axis
    }
    found = dict(zip(jobs, each(call, jobs.values()), strict=True))
    conditions = {name: one for name in cells if (one := known.get(name) or found.get(name)) is not None}
    idle = _idle(conditions, design)
    acting = {name: cells[name] for name in conditions if name not in _names(idle, whole=True)}
    series = tuple(dose_series(trials, design, box=box, each=each, idle=_names(idle), orders=orders, known=conditions))
    # the doses of every axis whose lowest level is the control, against it
    by_axis = (flips, *(summary for one, summary in series if one in design.other_axes))
    return ConditionStudySummary(
        design=design,
        conditions=conditions,
        effects=section(
            "Every condition against the control", lambda: _effects(acting, design, _names(idle), orders), tuple
        ),
        on_axes=tuple(one for summary in by_axis for agent in summary.agents if (one := _axis_effects(agent))),
        on_factors=section("Factors", lambda: _of_factors(acting, design.factors, design, orders, each), tuple),
        against_none=section(
            "No feedback", lambda: _of_factors(acting, no_feedback_factors(design), design, orders, each), tuple
        ),
        agents_compared=section(
            "Agents compared under conditions",
            lambda: agents_by_condition(acting, design, orders, each=each),
            tuple,
        ),
        series=series,
        whys=section("Why false reports change success", lambda: _whys(acting, design, orders), tuple),
        factorials=section("Factors of a factorial design", lambda: _factorials(cells, design), tuple),
        reference=reference,
        idle=tuple(one for one in idle if one.condition not in design.axis),
        unheeded=_unheeded(acting, design),
    )


def _condition_if_possible(
    trials: Sequence[Trial], reference: Reference, box: Lockbox, order: BlockOrder | None
) -> ConditionSummary | None:
    """One agent under one condition; None if what no other number replaces cannot be computed."""
    with of_whom(f"{trials[0].group} under {trials[0].condition}"):
        return section(
            "All numbers", lambda: condition_summary(trials, reference, box, _on_no_axis, order), lambda: None
        )


def _on_no_axis(trial: Trial) -> Place:
    return Place(trial.group, trial.modality, math.nan)


_Names = frozenset[tuple[str, str]]
"""Agents and conditions."""


def _idle(conditions: Mapping[tuple[str, str], ConditionSummary], design: Design) -> tuple[Idle, ...]:
    """What changed nothing, in the order of the conditions; a control is to change nothing."""
    acting = {arm.label: [str(arm.specs[place]) for place in arm.acting] for arm in design.arms}
    return tuple(
        one
        for (agent, label), summary in conditions.items()
        if label not in design.controls
        for one in idle_interventions(agent, label, summary.changed, acting.get(label, []))
    )


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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Compared:
    """The conditions of one agent in one modality, or the controls of all modalities, with what they are compared with.

    Attributes:
        agent: Its name.
        spec: Its spec.
        trials: Condition -> its trials, those of the modality that are in no comparison too.
        of: The comparisons of the modality.
        name: Which of its two families is meant.
    """

    agent: str
    spec: str
    trials: Mapping[str, Sequence[Trial]]
    of: Comparison
    name: str

    @property
    def family(self) -> tuple[str, str, bool]:
        """What is judged together with it: its family, the control, and whether the agent is a baseline."""
        return self.name, self.of.control, is_baseline(self.spec)

    @property
    def others(self) -> tuple[str, ...]:
        """What is compared with the control."""
        return self.of.others if self.name == CONDITIONS else self.of.controls

    @property
    def counts(self) -> bool:
        """Whether a difference can be found: it heeds something, and another condition has trials too."""
        others = [self.trials[name] for name in self.others if name in self.trials]
        if not others or self.of.control not in self.trials:
            return False
        members = [self.trials[self.of.control], *others]
        return heeded_at_most([trial for own in members for trial in own]) is None

    def effects(self, idle: frozenset[str], agents: int, order: BlockOrder | None) -> Effects | None:
        """The differences, and with conditions their interactions; ``agents`` are judged together."""
        beside = [name for name in self.of.labels if name not in (self.of.control, *self.others)]
        crossed = (self.of.crossings, self.of.grids) if self.name == CONDITIONS else ((), ())
        return effects(
            self.trials,
            self.of.control,
            *crossed,
            idle,
            axis=beside,
            agents=agents,
            family=self.name,
            order=order,
        )


def _effects(cells: _Cells, design: Design, idle: _Names, orders: Mapping[str, BlockOrder]) -> tuple[Effects, ...]:
    """Each modality's other conditions against its control, and the controls of all modalities against the first.

    In each, what the report says of the agents that the study is about is one family, and of baselines another.
    """
    compared = [
        _Compared(agent=agent, spec=design.spec_of(agent), trials=_of_agent(cells, agent, of), of=of, name=name)
        for agent in design.agents
        for of in map(design.comparison, design.modalities)
        for name in (CONDITIONS, *([CONTROLS] if of.controls else []))
    ]
    sizes = Counter(one.family for one in compared if one.counts)
    found = (
        one.effects(
            frozenset(label for name, label in idle if name == one.agent),
            max(1, sizes[one.family]),
            orders.get(one.agent),
        )
        for one in compared
    )
    return tuple(one for one in found if one)


def _of_agent(cells: _Cells, agent: str, of: Comparison) -> dict[str, Sequence[Trial]]:
    return {label: cells[agent, label] for label in of.labels if (agent, label) in cells}


def _of_factors(
    cells: _Cells, factors: Iterable[Factor], design: Design, orders: Mapping[str, BlockOrder], each: Each
) -> tuple[Effects, ...]:
    made = [make for factor in factors for make in factor_effects(cells, factor, design.agents, orders)]
    return tuple(one for one in each(call, made) if one is not None)


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
        interplays=(),
        agents=tested.agents,
        axis=found.axis.name,
    )


def _whys(cells: _Cells, design: Design, orders: Mapping[str, BlockOrder]) -> tuple[Why, ...]:
    """Why false reports change each agent's success, in each modality that has the arms for it.

    In each modality the agents that the study is about are one family, and baselines another. Those that play alike
    count too: that reports change their success by less than the margin is a conclusion.
    """
    asked: list[Callable[..., Why | None]] = []
    for agent in design.agents:
        for shown in map(design.shown, design.modalities):
            own = {arm.label: cells[agent, arm.label] for arm in shown if (agent, arm.label) in cells}
            asked.append(partial(why, own, shown, order=orders.get(agent)))
    answered = [(make, (one.modality, is_baseline(design.spec_of(one.agent)))) for make in asked if (one := make())]
    sizes = Counter(family for _, family in answered)
    return tuple(one for make, family in answered if (one := make(agents=sizes[family])))


def _factorials(cells: _Cells, design: Design) -> tuple[FactorialEffects, ...]:
    """What each factor of a factorial design does to each agent."""
    found = (
        factorial_effects({label: cells.get((agent, label), ()) for label in made.runs}, made)
        for agent in design.agents
        for modality in design.modalities
        for made in factorials_of(design.arms, modality)
    )
    return tuple(one for one in found if one is not None)


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
