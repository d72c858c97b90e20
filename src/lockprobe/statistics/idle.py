"""What the interventions of a condition changed, and conditions that changed nothing: these are no null results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lockprobe.foundation.spec import spec_name
from lockprobe.statistics.outcomes import REPORTS, ended
from lockprobe.trial.plant_change import PLANT
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class StepsChanged:
    """The steps that interventions changed in the ended trials of one agent under one condition.

    Attributes:
        steps: All steps of these trials.
        changed: Steps at which the agent was told, asked or remembered something else than without interventions, or
            another joint than the chosen one was attempted.
        by_intervention: Spec of every intervention -> the steps that it changed.
    """

    steps: int
    changed: int
    by_intervention: Mapping[str, int]

    @property
    def known(self) -> bool:
        """Whether there were interventions and steps that they could have changed."""
        return self.steps > 0 and bool(self.by_intervention)


@dataclass(frozen=True, slots=True, kw_only=True)
class Idle:
    """A condition in which nothing was changed, or one of its interventions changed nothing, for one agent.

    Attributes:
        agent: Its name, or its spec if it has none.
        condition: Name of the condition.
        intervention: The spec of the one that changed nothing; empty if all of them together did not.
        steps: The steps at which it could have.
    """

    agent: str
    condition: str
    intervention: str
    steps: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Unheeded:
    """A condition under which an agent chose the same joints as under the control in every trial.

    Attributes:
        agent: Its name, or its spec if it has none.
        condition: Name of the condition.
        control: Name of the control.
        changed: The steps that were changed.
    """

    agent: str
    condition: str
    control: str
    changed: int


def unheeded(trials: Sequence[Trial], control: Sequence[Trial]) -> Unheeded | None:
    """Whether an agent chose as under the control, although :data:`REPORTS` steps or more were changed; None if not.

    Trials of equal luck are compared. People are left out: different people play the conditions.
    """
    alone = {(trial.repetition, trial.trial): trial for trial in ended(control) if not trial.player}
    pairs = [(trial, other) for trial in ended(trials) if (other := alone.get((trial.repetition, trial.trial)))]
    changed = sum(trial.changed_steps for trial, _ in pairs)
    if changed < REPORTS or any(_chosen(trial) != _chosen(other) for trial, other in pairs):
        return None
    (first, other), *_ = pairs
    return Unheeded(agent=first.group, condition=first.condition, control=other.condition, changed=changed)


def _chosen(trial: Trial) -> list[str]:
    return [step.chosen or step.joint for step in trial.steps]


def steps_changed(trials: Sequence[Trial]) -> StepsChanged | None:
    """Add up what was changed in ended trials; None if some record does not say, or none has ended."""
    counted = ended(trials)
    names = {tuple(trial.changed) for trial in counted}
    if len(names) != 1:
        return None
    by_intervention: Counter[str] = Counter()
    for trial in counted:
        by_intervention.update(trial.changed)
    return StepsChanged(
        steps=sum(len(trial.steps) for trial in counted),
        changed=sum(trial.changed_steps for trial in counted),
        by_intervention=dict(by_intervention),
    )


def idle_interventions(agent: str, condition: str, found: StepsChanged | None, acting: Sequence[str]) -> list[Idle]:
    """What changed nothing: the condition as a whole, or some of the interventions that have an effect by their dose.

    Args:
        agent: Its name, or its spec if it has none.
        condition: Name of the condition.
        found: What its interventions changed, if it is known.
        acting: Specs of the interventions whose dose is not 0.
    """
    if found is None or not found.known:
        return []
    if not found.changed and not any(spec_name(spec) == PLANT for spec in acting):
        return [Idle(agent=agent, condition=condition, intervention="", steps=found.steps)]
    return [
        Idle(agent=agent, condition=condition, intervention=spec, steps=found.steps)
        for spec in acting
        if found.by_intervention.get(spec) == 0
    ]
