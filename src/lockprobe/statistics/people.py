"""Human participants in a study: success, steps, and agents' steps relative to theirs.

People count as one agent. A person plays several boxes and may learn from box to box, which agents cannot, so first
boxes are also counted apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lockprobe.statistics.clustered import ClusteredProportion, alike_weights, crossed_proportion
from lockprobe.statistics.outcomes import conditions_played, ended
from lockprobe.statistics.proportions import Proportion, proportion
from lockprobe.statistics.relative_steps import RelativeSteps, Steps, labels, relative_steps, steps_of
from lockprobe.trial.record import Fact, Trial

__all__ = ["AtPosition", "People", "PeopleAt", "people"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleAt:
    """The results of people under one condition, or in one modality over all conditions.

    Attributes:
        modality: How the box was shown.
        condition: Label of the condition; empty for all together.
        people: Number of people.
        success: Trials solved, clustered by player and luck.
        steps: Steps that they needed, with the Kaplan-Meier median.
    """

    modality: str
    condition: str
    people: int
    success: ClusteredProportion
    steps: Steps


@dataclass(frozen=True, slots=True, kw_only=True)
class AtPosition:
    """The results of people on the boxes at one position in their sequence.

    Attributes:
        position: From 1.
        success: Share solved, with Wilson's interval: each person has one box.
    """

    position: int
    success: Proportion


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    """All people of a study, over all conditions that they played.

    Attributes:
        people: People with such a trial that ended.
        trials: Those trials.
        fewest, most: Fewest and most trials of one person.
        success: Share solved over all conditions.
        alike: Mean over people of the share that each solved, [0, 1]; it equals ``success`` if all have as many trials.
        first: Share of first boxes solved, without learning from other boxes.
        positions: Results by position, where it is known.
        at: Results by condition: flip rates, ascending, then the others in the order of the trials.
        over: Results by modality, over all conditions.
        relative: Agents' steps relative to people's, by agent, modality and condition, with all together last.
        saw: Number of trials by fact about the display (view, language, feedback and so on) and its value.
    """

    people: int
    trials: int
    fewest: int
    most: int
    success: ClusteredProportion
    alike: float
    first: Proportion
    positions: tuple[AtPosition, ...]
    at: tuple[PeopleAt, ...]
    over: tuple[PeopleAt, ...]
    relative: tuple[RelativeSteps, ...]
    saw: Mapping[str, Mapping[str, int]]


_SAW = ("view", "history", "feedback", "design", "words", "page")
"""Facts of a person's trial that describe the display."""


def people(trials: Sequence[Trial]) -> People | None:
    """The results of people in the trials of one study; None if none of their trials has ended."""
    counted = ended(trials)
    own = [trial for trial in counted if trial.player]
    if not own:
        return None
    sizes = Counter(trial.agent for trial in own)
    conditions = conditions_played(own)
    modalities = dict.fromkeys(conditions.values())
    first = [trial for trial in own if trial.facts.get("position") == 1]
    return People(
        people=len(sizes),
        trials=len(own),
        fewest=min(sizes.values()),
        most=max(sizes.values()),
        success=_success(own),
        alike=float(np.mean([trial.solved for trial in own] * alike_weights([trial.agent for trial in own]))),
        first=proportion(sum(trial.solved for trial in first), len(first)),
        positions=tuple(_positions(own)),
        at=tuple(_at([t for t in own if t.condition == one], shown, one) for one, shown in conditions.items()),
        over=tuple(_at([t for t in own if t.modality == one], one, "") for one in modalities),
        relative=tuple(relative_steps(counted, own, conditions)),
        saw={
            name: dict(Counter(_said(trial.facts[name]) for trial in own if name in trial.facts))
            for name in _SAW
            if any(name in trial.facts for trial in own)
        },
    )


def _said(value: Fact) -> str:
    return ("no", "yes")[value] if isinstance(value, bool) else str(value)


def _success(trials: Sequence[Trial]) -> ClusteredProportion:
    person, luck = labels(trials)
    return crossed_proportion([trial.solved for trial in trials], np.ones(len(trials)), person, luck)


def _positions(trials: Sequence[Trial]) -> Iterable[AtPosition]:
    by: dict[int, list[bool]] = {}
    for trial in trials:
        position = trial.facts.get("position")
        if isinstance(position, int):
            by.setdefault(position, []).append(trial.solved)
    for position in sorted(by):
        yield AtPosition(position=position, success=proportion(sum(by[position]), len(by[position])))


def _at(trials: Sequence[Trial], modality: str, condition: str) -> PeopleAt:
    return PeopleAt(
        modality=modality,
        condition=condition,
        people=len({trial.agent for trial in trials}),
        success=_success(trials),
        steps=steps_of(trials, modality, condition),
    )
