"""The experimenter's settings for people (``people.toml``). They change no trial that models play.

::

    trials_each = 4                # boxes for each participant; each condition once if left out
    recruitment = ["PROLIFIC_PID", "STUDY_ID", "SESSION_ID"]
    completion_url = "https://app.prolific.com/submissions/complete?cc=ABC123"

    [[checks]]
    after = 2
    question = "Please choose blue, to show that you read this."
    options = ["red", "blue", "green"]
    right = "blue"

    [[questions]]
    name = "strategy"
    question = "How did you go about it?"
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.inputs import is_there, parse_json, read_input, read_toml
from lockprobe.people.file_errors import check_visible, first_error
from lockprobe.people.right_answers import Comprehension, OneRight, Options, SettingsPart, Text
from lockprobe.studies.file_names import PEOPLE_DIRECTORY

EXPERIMENT = "experiment.json"
"""The file of these settings, next to the diaries."""

SECRET = ("completion_url", "completion_code", "left_url", "left_code", "join_code")
"""Settings that are not shared with data."""


Url = Annotated[str, Field(pattern=r"^(https://\S{1,2000})?$")]
Code = Annotated[str, Field(max_length=100), AfterValidator(check_visible)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")]


class AttentionCheck(OneRight):
    """A question with one right answer, which shows whether a participant reads.

    ``after`` is the box after which it is asked; 0 for after the instructions.
    """

    after: Annotated[int, Field(ge=0, le=1000)]


class Question(SettingsPart):
    """A question at the end.

    Attributes:
        name: Its column in the tables.
        options: The choices; empty for a written answer.
        required: Whether it has to be answered.
        type: The form of a written answer: ``text``, ``number`` or ``integer``.
        low: The least number allowed; None for any.
        high: The largest number allowed; None for any.
    """

    name: Name
    question: Text
    options: Options = ()
    required: bool = False
    type: Literal["text", "number", "integer"] = "text"
    low: Annotated[float, Field(allow_inf_nan=False)] | None = None
    high: Annotated[float, Field(allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _limits_are_of_a_number(self) -> Self:
        limited = self.low is not None or self.high is not None
        if self.type == "text" and limited:
            raise ValueError('low and high need type = "number" or "integer"')
        if self.type != "text" and self.options:
            raise ValueError("a number, or options")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError("low is above high")
        return self


class Experiment(SettingsPart):
    """How people take part.

    Attributes:
        history: Whether earlier reports of the trial stay in view, as they do in a model's conversation.
        history_open: Whether earlier reports are unfolded when a box begins; the same on every device.
        device: Whether the diary keeps the device of each choice (mouse, finger, pen, keyboard) and the size of the
            window, in CSS pixels.
        feedback: Whether the end of a box says if it was opened. Models are not told.
        design: ``within``: each participant plays every condition; ``between``: each plays one.
        trials_each: Boxes per participant; None is each condition once, or one box in a between design.
        practice: Name of the practice box; empty for none. Its rule is none of those of the boxes that people play.
        practice_layout: ``shuffled``: everybody has a panel of their own in practice, unless that of the study is
            fixed; ``fixed``: that of the box, as in directories of earlier releases.
        participants: The most participants; None is as many as the study has trials for.
        language: ``en``, another shipped language, or the path of a file with texts.
        recruitment: Parameters of the URL that are kept, as recruitment platforms set them. The first identifies a
            person, who can take part only once. Empty for none.
        comprehension: The questions on the instructions.
        say_false: Whether the instructions say that reports can be wrong.
        completion_url: Where participants go at the end.
        completion_code: The code that they enter there.
        left_url: Where all others go: who do not agree, find no place, are too late or screened out, or withdraw.
        left_code: Their code.
        require_id: Whether the URL has to hold the first parameter of ``recruitment``.
        join_code: A code to join, in the URL (``?code=…``) or on the page; empty for none.
        away_minutes: Minutes without an act after which a place may be given to somebody who finds no other.
        checks: Attention checks.
        questions: Questions at the end.
    """

    history: bool = True
    history_open: bool = True
    device: bool = True
    feedback: bool = False
    design: Literal["within", "between"] = "within"
    trials_each: Annotated[int, Field(ge=1, le=1000)] | None = None
    practice: Annotated[str, Field(max_length=40)] = "common-cause-3"
    practice_layout: Literal["shuffled", "fixed"] = "shuffled"
    participants: Annotated[int, Field(ge=1, le=100_000)] | None = None
    language: Annotated[str, Field(min_length=1, max_length=1000)] = "en"
    recruitment: Annotated[tuple[Name, ...], Field(max_length=8)] = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
    comprehension: Comprehension = Comprehension()
    say_false: bool = False
    completion_url: Url = ""
    completion_code: Code = ""
    left_url: Url = ""
    left_code: Code = ""
    require_id: bool = False
    join_code: Annotated[str, Field(pattern=r"^([A-Za-z0-9_.-]{4,64})?$")] = ""
    away_minutes: Annotated[float, Field(gt=0, le=60 * 24 * 365)] = 1440.0
    checks: Annotated[tuple[AttentionCheck, ...], Field(max_length=20)] = ()
    questions: Annotated[tuple[Question, ...], Field(max_length=40)] = ()

    @model_validator(mode="after")
    def _names_are_different(self) -> Self:
        names = [question.name for question in self.questions]
        if len(set(names)) < len(names):
            raise ValueError("two questions have the same name")
        if self.require_id and not self.recruitment:
            raise ValueError("require_id needs a parameter in recruitment")
        return self


def experiment_from(settings: Mapping[str, object], path: Path) -> Experiment:
    """The settings in a file.

    Raises:
        BadFile: If one is wrong; the message names the key.
    """
    try:
        return Experiment.model_validate(settings)
    except ValidationError as error:
        raise BadFile(path, first_error(error, Experiment)) from None


def experiment_with(experiment: Experiment, settings: Mapping[str, object]) -> Experiment:
    """The same with other settings.

    Raises:
        UserMistake: If one is wrong.
    """
    try:
        return Experiment.model_validate({**experiment.model_dump(), **settings})
    except ValidationError as error:
        raise UserMistake(first_error(error, Experiment)) from None


def read_experiment(path: Path) -> Experiment:
    """The settings in a user's TOML file.

    Raises:
        BadFile: If one is wrong; the message names the key.
    """
    return experiment_from(read_toml(path), path)


def kept_experiment(directory: Path) -> Experiment | None:
    """The settings under which people took part in a study; None where none are stored.

    Raises:
        BadFile: If the file is damaged.
    """
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    if not is_there(path):
        return None
    settings = parse_json(read_input(path), path)
    if not isinstance(settings, dict):
        raise BadFile(path, "not the settings of an experiment")
    return experiment_from({"practice_layout": "fixed", **settings}, path)
