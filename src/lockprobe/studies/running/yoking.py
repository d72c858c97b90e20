"""Yoked controls: trials with as many false reports as another trial of the same agent, at random steps.

The intervention ``yoked?how=looping`` controls for the number of false reports under ``flip?while=looping``, which
depends on what the agent does. A yoked trial is played after its source trial and takes the number from that record. A
yoked control can still differ from its source by chance alone (Church, Psychological Review 71, 1964): it is an extra
of the study ``why``, not its evidence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.yoked import Yoked
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial
from lockprobe.trial.told_outcome import flipped

__all__ = ["as_recorded", "bound", "check_sources", "is_yoked"]


def is_yoked(condition: Condition) -> bool:
    """Whether the trials of a condition depend on another trial whose number of false reports is not yet known."""
    return any(_rate(spec) is not None for spec in condition.specs)


def _rate(spec: str) -> float | None:
    """The flip rate of the source, if an intervention is yoked to a trial of the same agent; else None."""
    found = Spec.parse(spec, "intervention")
    if found.full_name != Yoked.name or found.options.get("how") != "looping" or "at" in found.options:
        return None
    return float(found.options.get("p", "0"))


def _source_of(condition: Condition, conditions: Sequence[Condition]) -> Condition | None:
    """The source condition: the same with ``flip?while=looping`` instead of the yoked intervention; None without."""
    wanted = [_source(spec) for spec in condition.specs]
    for one in conditions:
        if one.modality == condition.modality and [_options(spec) for spec in one.specs] == wanted:
            return one
    return None


def _source(spec: str) -> tuple[str, dict[str, str]]:
    rate = _rate(spec)
    return _options(spec) if rate is None else ("flip", {"p": f"{rate:g}", "while": "looping"})


def _options(spec: str) -> tuple[str, dict[str, str]]:
    found = Spec.parse(spec, "intervention")
    return found.full_name, dict(found.options)


def check_sources(conditions: Sequence[Condition]) -> None:
    """Refuse yoked conditions whose source condition is missing.

    Raises:
        BadValue: If there is one.
    """
    for one in conditions:
        if is_yoked(one) and _source_of(one, conditions) is None:
            rate = next(rate for spec in one.specs if (rate := _rate(spec)) is not None)
            needed = f"with the condition flip?p={rate:g}&while=looping in the same study, whose trials it follows"
            raise BadValue("condition", one.label, needed)


def bound(plan: Plan, study: Study, trials: Mapping[str, Trial]) -> Plan | None:
    """The plan with the steps of its false reports; None as long as its source trial is owed.

    Args:
        plan: Of a condition that is yoked; any other stays as it is.
        study: The study.
        trials: Its recorded trials, by key.
    """
    if not is_yoked(plan.condition):
        return plan
    source = _source_of(plan.condition, study.conditions)
    assert source is not None  # a study has it
    followed = trials.get(study.plan(plan.agent, source, plan.repetition, plan.trial).key)
    if followed is None or followed.owed_again:
        return None
    steps = max(0, len(followed.steps) - 1)  # nobody acts on the last report
    lies = sum(flipped(followed, i) for i in range(steps))
    drawn = plan.stream("yoked").permutation(steps)[:lies] + 1
    return _with_steps(plan, tuple(sorted(drawn.tolist())))


def as_recorded(plan: Plan, trial: Trial) -> Plan:
    """The plan with the steps of the false reports in its own record."""
    if not is_yoked(plan.condition):
        return plan
    steps = next(str(channel["at"]) for channel in trial.channels if channel.get("how") == "looping")
    return _with_steps(plan, tuple(map(int, steps.split(";"))))


def _with_steps(plan: Plan, steps: tuple[int, ...]) -> Plan:
    made = interventions_in(plan.condition)
    acting = (
        replace(one, at=steps or (0,)) if isinstance(one, Yoked) and one.how == "looping" else one for one in made
    )
    condition = replace(plan.condition, interventions=tuple(acting), name=plan.condition.label)
    return replace(plan, condition=condition)
