"""The options of one trial: those of a study, each with one value, under the same names and defaults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypedDict

from pydantic import ValidationError

from lockprobe.boxes.box import LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.flip import FlipKind
from lockprobe.studies.options.study_options import StudyOptions, refusal_of
from lockprobe.studies.study import LIMITS
from lockprobe.trial.briefing import Ask
from lockprobe.trial.condition import Condition
from lockprobe.trial.protocols import Agent, Intervention


class TrialOptions(TypedDict, total=False):
    """The options of one trial.

    Those that are not listed here mean what they mean in
    :class:`lockprobe.studies.options.study_options.StudyOptions`; without them a trial is that of a study of flips.

    Attributes:
        agent: Agent spec, or an object with the :class:`lockprobe.trial.protocols.Agent` protocol (human-inspired).
        p: Flip rate, [0, 1] (0).
        condition: What acts in the trial: specs with plus signs between (``tremble?p=0.1 + nudge``), interventions, or
            a condition; ``lockprobe list interventions`` lists them. A flip rate is put in front of it.
        modality: How the box is shown, as its spec, where the condition does not say it.
        repetition: Repetition of the study, from 1 (1).
        trial: Trial of the repetition, from 1 (1).
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.
    """

    agent: str | Agent | None
    box: str | Path | Lockbox | None
    p: float | None
    flip: FlipKind | None
    condition: str | Condition | Sequence[Intervention] | None
    modality: str | None
    plant: str | None
    layout: LayoutKind | None
    shuffle: Shuffle | None
    max_steps: int | None
    assessment: bool | None
    hypothesis: Ask | None
    seed: int | None
    repetition: int | None
    trial: int | None
    pictures: Path | str | None


_LISTED = ("p", "modality")
"""Of which a study has several."""

_PLURAL = {"repetition": "repetitions", "trial": "trials"}
"""The place of a trial -> the extent of the shortest study that has it."""

_OBJECTS = ("agent", "condition", "pictures")
"""What need not be text, and is checked here."""


def trial_options(given: Mapping[str, Any]) -> StudyOptions:
    """The options of the shortest study that has the trial; agent, condition and pictures are checked and left out.

    A value of None counts as left out.

    Raises:
        UnknownName: If one does not exist; the message lists those that do.
        BadValue: If one has a value that it cannot have.
    """
    for name in given:
        if name not in TrialOptions.__annotations__:
            raise UnknownName("option", name, TrialOptions.__annotations__)
    _check_objects(given)
    asked = {
        _PLURAL.get(name, name): [value] if name in _LISTED else value
        for name, value in given.items()
        if name not in _OBJECTS and value is not None
    }
    try:
        found = StudyOptions.model_validate(asked)
    except ValidationError as error:
        where = error.errors()[0]["loc"][0]
        name = next(name for name in given if _PLURAL.get(name, name) == where)
        raise refusal_of(error, name, given[name]) from None
    for one, several in _PLURAL.items():
        if (number := getattr(found, several)) is not None:
            check_whole(one, number, 1, LIMITS[several])
    return found


def _check_objects(given: Mapping[str, Any]) -> None:
    agent, condition, pictures = (given.get(name) for name in _OBJECTS)
    if not isinstance(agent, str | Agent | None):
        raise BadValue("agent", agent, "an agent spec, or an object with facts and decide()")
    several = isinstance(condition, Sequence) and all(isinstance(one, Intervention) for one in condition)
    if not (several or isinstance(condition, str | Condition | None)):
        raise BadValue("condition", condition, "specs with plus signs between, a Condition, or a list of interventions")
    if not isinstance(pictures, str | Path | None):
        raise BadValue("pictures", pictures, "a directory")
