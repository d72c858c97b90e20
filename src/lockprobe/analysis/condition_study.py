"""The numbers of the conditions beside a study's flip axis: each against its control, crossed ones, doses, causes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import call

from lockprobe.analysis.axis_trials import Place
from lockprobe.analysis.behaviour import heeded_at_most
from lockprobe.analysis.condition import ConditionSummary, condition_summary
from lockprobe.analysis.dose_grid import grids
from lockprobe.analysis.effects import Effect, Effects, effects
from lockprobe.analysis.idle import Idle, Unheeded, idle_interventions, unheeded
from lockprobe.analysis.reference import Reference, reference_of
from lockprobe.analysis.series import Series, SeriesArm, control_of, crossings, series_of, series_of_agents
from lockprobe.analysis.summary import AgentSummary, StudySummary, is_reference, summarise
from lockprobe.analysis.why import Why, why
from lockprobe.lockbox.box import Lockbox
from lockprobe.parallel import Each
from lockprobe.record import Trial
from lockprobe.sections import of_whom, section

__all__ = ["ConditionStudySummary", "summarise_conditions"]

_Cells = Mapping[tuple[str, str], Sequence[Trial]]
"""The trials of every agent under every condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionStudySummary:
    """The numbers of the conditions beside the flip axis.

    Each contrast belongs to one family. The flip rates of a modality against the truth are a family of the axis
    (:func:`lockprobe.analysis.summary.summarise`); all other conditions against their control are one, here. So
    conditions beside flips change no P value of flips, and flips none of theirs.

    Attributes:
        agents: Its agents.
        arms: All conditions of the study as their specs tell them.
        conditions: Every agent under every condition -> its numbers, under (agent, condition).
        effects: Every agent's other conditions against their control.
        axis: The same of the flip axis, as the axis has tested them.
        series: Conditions that differ in one dose alone, each with the numbers over that dose.
        whys: Of a study of controls: why false reports change each agent's success.
        reference: What blind agents and the shortest plan reach on the box.
        idle: Conditions, other than controls, in which nothing was changed, and interventions that changed nothing in a
            whole condition. No comparison has the former, and no interaction or series has either.
        unheeded: Conditions under which an agent chose as under the control, although steps were changed.
    """

    agents: tuple[str, ...]
    arms: tuple[SeriesArm, ...]
    conditions: Mapping[tuple[str, str], ConditionSummary]
    effects: tuple[Effects, ...]
    axis: tuple[Effects, ...]
    series: tuple[tuple[Series, StudySummary], ...]
    whys: tuple[Why, ...]
    reference: Reference
    idle: tuple[Idle, ...] = ()
    unheeded: tuple[Unheeded, ...] = ()

    @property
    def together(self) -> tuple[Effects, ...]:
        """The effects of both families beside each other, by agent and modality, for a figure."""
        found: dict[tuple[str, str], Effects] = {}
        for one in (*self.axis, *self.effects):
            first = found.get((one.agent, one.modality))
            found[one.agent, one.modality] = one if first is None else replace(one, effects=first.effects + one.effects)
        order = [(agent, modality) for agent in self.agents for modality in dict.fromkeys(name for _, name in found)]
        return tuple(found[name] for name in order if name in found and found[name].effects)

    @property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about: those that are no reference, or all if all are."""
        return tuple(agent for agent in self.agents if not is_reference(agent)) or self.agents


def summarise_conditions(
    trials: Sequence[Trial],
    arms: Sequence[SeriesArm],
    flips: StudySummary,
    axis: frozenset[str],
    *,
    agents: tuple[str, ...],
    box: Lockbox,
    budget: int,
    each: Each = map,
) -> ConditionStudySummary:
    """Compute the numbers of the conditions beside the flip axis.

    Args:
        trials: All trials of the study.
        arms: All its conditions.
        flips: The numbers of its flip axis.
        axis: The conditions on that axis.
        agents: Its agents.
        box: Its box.
        budget: Most steps of a trial.
        each: A map function over agents, sequential or parallel.
    """
    reference = reference_of(box, budget)
    known = {(one.agent, one.name): one for one in flips.conditions}
    cells = _cells(trials)
    jobs = {
        name: partial(_condition_if_possible, members, reference, box)
        for name, members in cells.items()
        if name[1] not in axis
    }
    found = dict(zip(jobs, each(call, jobs.values()), strict=True))
    conditions = {name: one for name in cells if (one := known.get(name) or found.get(name)) is not None}
    idle = _idle(found, arms)
    acting = {name: cells[name] for name in conditions if name not in _names(idle, whole=True)}
    return ConditionStudySummary(
        agents=agents,
        arms=tuple(arms),
        conditions=conditions,
        effects=section(
            "Every condition against the control", lambda: _effects(acting, arms, agents, _names(idle), axis), tuple
        ),
        axis=tuple(one for agent in flips.agents if (one := _axis_effects(agent))),
        series=section("Doses", lambda: _series(trials, arms, agents, box, each, _names(idle), axis), tuple),
        whys=section("Why false reports change success", lambda: _whys(acting, arms, agents), tuple),
        reference=reference,
        idle=idle,
        unheeded=_unheeded({name: own for name, own in acting.items() if name[1] not in axis}, acting, arms),
    )


def _condition_if_possible(trials: Sequence[Trial], reference: Reference, box: Lockbox) -> ConditionSummary | None:
    """One agent under one condition; None if what no other number replaces cannot be computed."""
    with of_whom(f"{trials[0].group} under {trials[0].condition}"):
        return section("All numbers", lambda: condition_summary(trials, reference, box, _on_no_axis), lambda: None)


def _on_no_axis(trial: Trial) -> Place:
    return Place(trial.group, trial.modality, math.nan)


_Names = frozenset[tuple[str, str]]
"""Agents and conditions."""


def _idle(conditions: Mapping[tuple[str, str], ConditionSummary | None], arms: Sequence[SeriesArm]) -> tuple[Idle, ...]:
    """What changed nothing, in the order of the conditions; a control is to change nothing."""
    controls = {control.label for arm in arms if (control := control_of(arms, arm.modality))}
    acting = {arm.label: [str(arm.specs[place]) for place in arm.acting] for arm in arms}
    return tuple(
        one
        for (agent, label), summary in conditions.items()
        if summary is not None and label not in controls
        for one in idle_interventions(agent, label, summary.changed, acting.get(label, []))
    )


def _unheeded(cells: _Cells, beside: _Cells, arms: Sequence[SeriesArm]) -> tuple[Unheeded, ...]:
    """Conditions under which an agent played as under its control, which is one of those beside them."""
    controls = {arm.label: control for arm in arms if (control := control_of(arms, arm.modality))}
    return tuple(
        one
        for (agent, label), members in cells.items()
        if label in controls and label != controls[label].label
        if (one := unheeded(members, beside.get((agent, controls[label].label), ())))
    )


def _names(idle: Sequence[Idle], *, whole: bool = False) -> _Names:
    """The conditions in which something changed nothing; with ``whole`` only those in which all of it did not."""
    return frozenset((one.agent, one.condition) for one in idle if not (whole and one.intervention))


def _cells(trials: Sequence[Trial]) -> dict[tuple[str, str], list[Trial]]:
    """The trials of every agent under every condition."""
    cells: dict[tuple[str, str], list[Trial]] = {}
    for trial in trials:
        cells.setdefault((trial.group, trial.condition), []).append(trial)
    return cells


@dataclass(frozen=True, slots=True, kw_only=True)
class _Compared:
    """The conditions of one agent in one modality, with the control that they are compared with."""

    agent: str
    trials: Mapping[str, Sequence[Trial]]
    control: str
    shown: Sequence[SeriesArm]
    axis: frozenset[str]

    @property
    def compared(self) -> Mapping[str, Sequence[Trial]]:
        """Those that are no dose of an axis, with the control."""
        return {name: own for name, own in self.trials.items() if name == self.control or name not in self.axis}

    @property
    def baseline(self) -> bool:
        """Whether the agent is a baseline."""
        return is_reference(self.agent)

    @property
    def counts(self) -> bool:
        """Whether a difference can be found: it heeds something, and another condition has trials too."""
        return (
            self.control in self.compared
            and len(self.compared) > 1
            and heeded_at_most([trial for members in self.compared.values() for trial in members]) is None
        )


def _effects(
    cells: _Cells, arms: Sequence[SeriesArm], agents: Sequence[str], idle: _Names, axis: frozenset[str]
) -> tuple[Effects, ...]:
    """Each modality's conditions against its control; the first modality is also compared with the others' controls.

    What the report says of the agents that the study is about is one family, and of baselines another.
    """
    compared = [one for agent in agents for one in _compared(cells, arms, agent, axis)]
    sizes = Counter(one.baseline for one in compared if one.counts)
    found = (
        effects(
            one.trials,
            one.control,
            crossings(one.shown),
            grids(one.shown),
            {label for name, label in idle if name == one.agent},
            axis=one.axis,
            agents=max(1, sizes[one.baseline]),
        )
        for one in compared
    )
    return tuple(one for one in found if one)


def _axis_effects(found: AgentSummary) -> Effects | None:
    """The doses of an axis against the lowest one, with the P values of the axis; None if none was compared."""
    tested = found.inference.difference
    names = {one.p: one.name for one in found.conditions}
    if not tested.at or tested.lowest is None or found.blind:
        return None
    return Effects(
        agent=found.agent,
        modality=found.modality,
        control=names[tested.lowest],
        effects=tuple(Effect(condition=names[one.p], difference=one) for one in tested.at),
        interplays=(),
        agents=tested.agents,
    )


def _compared(cells: _Cells, arms: Sequence[SeriesArm], agent: str, axis: frozenset[str]) -> Iterator[_Compared]:
    modalities = list(dict.fromkeys(arm.modality for arm in arms))
    controls = [control_of(arms, modality) for modality in modalities[1:]]
    for modality in modalities:
        beside = controls if modality == modalities[0] else []
        own = {
            arm.label: cells[agent, arm.label]
            for arm in arms
            if (arm.modality == modality or arm in beside) and (agent, arm.label) in cells
        }
        shown = [arm for arm in arms if arm.modality == modality]
        if (control := control_of(arms, modality)) is not None:
            others = axis - {arm.label for arm in beside if arm is not None}
            yield _Compared(agent=agent, trials=own, control=control.label, shown=shown, axis=others)


def _whys(cells: _Cells, arms: Sequence[SeriesArm], agents: Sequence[str]) -> tuple[Why, ...]:
    """Why false reports change each agent's success, in each modality that has the arms for it.

    The agents that the study is about are one family, and baselines another. Those that play alike count too: that
    reports change their success by less than the margin is a conclusion.
    """
    asked: list[Callable[..., Why | None]] = []
    for agent in agents:
        for modality in dict.fromkeys(arm.modality for arm in arms):
            shown = [arm for arm in arms if arm.modality == modality]
            own = {arm.label: cells[agent, arm.label] for arm in shown if (agent, arm.label) in cells}
            asked.append(partial(why, own, shown))
    answered = [(make, is_reference(one.agent)) for make in asked if (one := make())]
    sizes = Counter(baseline for _, baseline in answered)
    return tuple(one for make, baseline in answered if (one := make(agents=sizes[baseline])))


def _series(
    trials: Sequence[Trial],
    arms: Sequence[SeriesArm],
    agents: Sequence[str],
    box: Lockbox,
    each: Each,
    idle: _Names,
    axis: frozenset[str],
) -> tuple[tuple[Series, StudySummary], ...]:
    """The numbers over every other dose, and over options of agents."""
    found = []
    for series in (one for one in series_of(arms) if not one.doses.keys() <= axis):
        members = [
            trial
            for trial in trials
            if trial.condition in series.doses
            and not (series.doses[trial.condition] and (trial.group, trial.condition) in idle)
        ]
        found.append((series, members, partial(_by_condition, series)))
    control = control_of(arms, arms[0].modality)
    for series in series_of_agents(agents):
        own = [t for t in trials if t.agent in series.doses and control is not None and t.condition == control.label]
        found.append((series, own, partial(_by_option, series)))
    return tuple(
        (series, summarise(members, box, each=each, axis=series.axis, place=place))
        for series, members, place in found
        if members
    )


def _by_condition(series: Series, trial: Trial) -> Place:
    """The place of a trial by the dose of its condition."""
    return Place(trial.group, series.modality, series.doses[trial.condition])


def _by_option(series: Series, trial: Trial) -> Place:
    """The place of a trial by an option of its agent."""
    return Place(series.agent, trial.modality, series.doses[trial.agent])
