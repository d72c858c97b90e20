"""Capacity: how many people a study has places for, and what each of them plays."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from lockprobe.foundation.errors import UserMistake
from lockprobe.people.assignment import boxes_each, conditions_of, williams
from lockprobe.people.experiment import Experiment
from lockprobe.studies.study import Study

__all__ = ["Capacity", "capacity_of", "check_capacity", "trials_for", "what_each_plays"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Capacity:
    """Places of a study: for ``people`` who play ``boxes`` each, with ``over`` boxes left when all have played."""

    people: int
    boxes: int
    conditions: int
    over: int


def capacity_of(study: Study, experiment: Experiment) -> Capacity:
    """How many people a study has places for."""
    conditions, luck = len(conditions_of(study)), study.repetitions * study.trials
    boxes = boxes_each(study, experiment)
    people = conditions * (luck // boxes) if experiment.design == "between" else conditions * luck // boxes
    return Capacity(people=people, boxes=boxes, conditions=conditions, over=conditions * luck - people * boxes)


def trials_for(people: int, conditions: int, repetitions: int, experiment: Experiment) -> int:
    """Trials per condition and repetition that give this many people places.

    >>> trials_for(40, 4, 1, Experiment()), trials_for(40, 4, 1, Experiment(design="between"))
    (40, 10)
    """
    if experiment.design == "between":
        boxes = experiment.trials_each or 1
        luck = ceil(people / conditions) * boxes
    else:
        boxes = experiment.trials_each or conditions
        luck = max(boxes, ceil(people * boxes / conditions))  # nobody meets the same luck twice
    return ceil(luck / repetitions)


def check_capacity(study: Study, experiment: Experiment) -> None:
    """Refuse a study with too few trials for its participants; the message names the options that help.

    Raises:
        UserMistake: If there are more people than places, or fewer trials than conditions where everybody plays each.
    """
    found, wanted = capacity_of(study, experiment), experiment.participants
    trials = trials_for(wanted or 1, found.conditions, study.repetitions, experiment)
    if experiment.design == "within" and experiment.trials_each is None and found.boxes < found.conditions:
        raise UserMistake(
            f"everybody plays every condition, so repetitions x trials: got {found.boxes}, expected at least "
            f'{found.conditions}, the number of conditions; give --trials {trials}, or set design = "between"'
        )
    if wanted is not None and wanted > found.people:
        raise UserMistake(
            f"participants: got {wanted}, expected at most {found.people}, the places of this study "
            f"({found.boxes} boxes each); give --trials {trials}"
        )


def what_each_plays(study: Study, experiment: Experiment) -> tuple[str, ...]:
    """How many people have places and what each plays, in one or two sentences."""
    found = capacity_of(study, experiment)
    several = f"{found.boxes} boxes" if found.boxes > 1 else "1 box"
    if experiment.design == "between":
        plays = f"{several} of one condition of {found.conditions}"
    elif found.boxes < found.conditions:
        plays = f"{several}, not every one of the {found.conditions} conditions"
    elif found.boxes % found.conditions:
        plays = f"{several}: every one of the {found.conditions} conditions, some of them once more"
    else:
        plays = f"{several}: each of the {found.conditions} conditions {_times(found.boxes // found.conditions)}"
    people = min(found.people, experiment.participants or found.people)
    taking_part = f"Places for {people} people" + (f" of {found.people}" if people < found.people else "")
    sentences = [f"{taking_part}, each plays {plays}, up to {study.max_steps} steps a box."]
    rows = found.conditions if experiment.design == "between" else len(williams(found.conditions))
    if rows > 1 and people % rows and found.boxes >= (1 if experiment.design == "between" else found.conditions):
        what = "Conditions" if experiment.design == "between" else "Orders of the conditions"
        sentences.append(f"{what} are balanced after every {rows} people; {people} are {people % rows} over.")
    return tuple(sentences)


def _times(number: int) -> str:
    return {1: "once", 2: "twice"}.get(number, f"{number} times")
