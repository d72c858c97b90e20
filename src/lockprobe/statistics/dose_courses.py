"""Courses over every dose but plain flip rates: other interventions, other kinds of flips, options of agents."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.conditions.axis import axis_key
from lockprobe.statistics.conditions.axis_trials import Place
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.series import Series
from lockprobe.statistics.course import Course, courses
from lockprobe.statistics.idle import idle_interventions
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import Trial


def dose_courses(
    trials: Sequence[Trial], design: Design, orders: Mapping[str, BlockOrder] = NO_ORDERS
) -> Iterator[Course]:
    """The courses over every series of a design; those of options of agents are under the first control.

    A condition in which a dose changed nothing is in none.

    Args:
        trials: All trials of the study.
        design: Its design.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
    """
    acting = {arm.label: [str(arm.specs[place]) for place in arm.acting] for arm in design.arms}
    idle = {
        (agent, label)
        for (agent, label), own in grouped(trials, lambda trial: (trial.group, trial.condition)).items()
        if label not in design.controls and idle_interventions(own, acting.get(label, ()))
    }
    first, known = design.control(design.arms[0].label), Counter[tuple[object, ...]]()
    times = Counter(series.axis for series in design.series)

    def lies_on(series: Series, trial: Trial) -> bool:
        if series.agent:
            return trial.group in series.doses and trial.condition == first
        dose = series.doses.get(trial.condition)
        return dose is not None and not (dose and (trial.group, trial.condition) in idle)

    for series in design.series:
        axis = series.axis
        if members := [trial for trial in trials if lies_on(series, trial)]:
            known[axis, series.modality, series.agent] += 1
            key = axis_key(axis.name, axis.options, axis.rest, known[axis, series.modality, series.agent])
            place = partial(_in_series, series)
            yield from courses(members, axis, key, place, several=times[axis] > 1, orders=orders)


def _in_series(series: Series, trial: Trial) -> Place:
    if series.agent:
        return Place(series.agent, trial.modality, series.doses[trial.group])
    return Place(trial.group, series.modality, series.doses[trial.condition])
