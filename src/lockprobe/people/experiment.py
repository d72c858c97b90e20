"""The experimenter's settings for people (``people.toml``). They change no trial that models play."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from lockprobe.foundation.errors import BadFile, BadValue, UnknownName, UserMistake
from lockprobe.foundation.inputs import is_there, parse_json, read_input, read_toml
from lockprobe.foundation.validation import plain
from lockprobe.studies.file_names import PEOPLE_DIRECTORY

EXPERIMENT = "experiment.json"
"""The file of these settings, in the directory of people."""

ENDS = ("completion_url", "completion_code", "left_url", "left_code", "join_code")
"""The settings of where participants come from and go to."""


class SettingsPart(BaseModel):
    """Base of what an experimenter writes into a file."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _bare(text: str) -> str:
    """Refuse surrounding space: it is invisible, and would make another option."""
    if text != text.strip():
        raise ValueError(f"got {text!r}, expected words without space around them")
    return text


Text = Annotated[str, Field(min_length=1, max_length=2000), AfterValidator(_bare)]
Option = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_bare)]
Options = Annotated[tuple[Option, ...], Field(max_length=20)]
Url = Annotated[str, Field(pattern=r"^(https://\S{1,2000})?$")]
Code = Annotated[str, Field(max_length=100)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")]

_WRITTEN = {"number": re.compile(r"[+-]?[0-9]{1,15}([.,][0-9]{1,15})?"), "integer": re.compile(r"[+-]?[0-9]{1,15}")}


class Question(SettingsPart):
    """A question: one of the options is chosen; without options the answer is written.

    Attributes:
        required: Whether it has to be answered.
        type: The form of a written answer.
        low: The least number allowed; None for any.
        high: The largest number allowed; None for any.
    """

    question: Text
    options: Options = ()
    required: bool = True
    type: Literal["text", "number", "integer"] = "text"
    low: Annotated[float, Field(allow_inf_nan=False)] | None = None
    high: Annotated[float, Field(allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _can_be_answered(self) -> Self:
        ends, number = [end for end in (self.low, self.high) if end is not None], self.type != "text"
        if (self.options and number) or (ends and not number) or ends != sorted(ends):
            raise ValueError("low and high, in this order, are of a number or an integer, which has no options")
        return self

    def takes(self, given: str) -> bool:
        """Whether an answer is acceptable.

        >>> age = Question(question="How old are you?", required=False, type="integer", low=18, high=120)
        >>> [age.takes(answer) for answer in ("34", "banana", "7", "")]
        [True, False, False, True]
        """
        answer = given.strip()
        if not answer:
            return not self.required
        if self.options or self.type == "text":
            return given in self.options or not self.options
        if not _WRITTEN[self.type].fullmatch(answer):
            return False
        number = float(answer.replace(",", "."))
        return (self.low is None or self.low <= number) and (self.high is None or number <= self.high)


class OneRight(Question):
    """A question with options, one of which is right."""

    options: Annotated[Options, Field(min_length=2)]
    right: str

    @model_validator(mode="after")
    def _right_is_an_option(self) -> Self:
        if self.right not in self.options or len(set(self.options)) < len(self.options):
            raise ValueError("options must be distinct, and right must be one of them")
        return self


class AttentionCheck(OneRight):
    """Shows whether a participant reads. It is asked after box ``after``; 0 for after the instructions."""

    after: Annotated[int, Field(ge=0, le=1000)]


class LastQuestion(Question):
    """A question at the end; ``name`` is its column in the tables."""

    name: Name
    required: bool = False


class Experiment(SettingsPart):
    """How people take part. The example that ``lockprobe serve --write-people FILE`` writes explains each setting.

    None for ``trials_each`` is each condition once, for ``participants`` as many as the study has trials for, for
    ``rounds`` of questions on the instructions as many as it takes.
    """

    history: bool = True
    device: bool = True
    feedback: bool = False
    trials_each: Annotated[int, Field(ge=1, le=1000)] | None = None
    practice: Annotated[str, Field(max_length=40)] = "common-cause-3"
    participants: Annotated[int, Field(ge=1, le=100_000)] | None = None
    language: Annotated[str, Field(min_length=1, max_length=1000)] = "en"
    recruitment: Annotated[tuple[Name, ...], Field(max_length=8)] = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
    comprehension: bool = True
    rounds: Annotated[int, Field(ge=1, le=100)] | None = None
    say_false: bool = False
    completion_url: Url = ""
    completion_code: Code = ""
    left_url: Url = ""
    left_code: Code = ""
    require_id: bool = False
    join_code: Annotated[str, Field(pattern=r"^([A-Za-z0-9_.-]{4,64})?$")] = ""
    away_minutes: Annotated[float, Field(gt=0, le=60 * 24 * 365)] = 1440.0
    checks: Annotated[tuple[AttentionCheck, ...], Field(max_length=20)] = ()
    questions: Annotated[tuple[LastQuestion, ...], Field(max_length=40)] = ()

    @model_validator(mode="after")
    def _names_are_different(self) -> Self:
        if len({question.name for question in self.questions}) < len(self.questions):
            raise ValueError("two questions have the same name")
        if self.require_id and not self.recruitment:
            raise ValueError("require_id needs a parameter in recruitment")
        return self


def experiment_from(settings: object, path: Path | None = None) -> Experiment:
    """Settings, of a file if they are of one.

    Raises:
        UserMistake: If one is wrong; the message names the key.
    """
    try:
        return Experiment.model_validate(settings)
    except ValidationError as error:
        said = first_error(error, Experiment)
        raise (UserMistake(said) if path is None else BadFile(path, said)) from None


def read_experiment(path: Path) -> Experiment:
    """The settings in a user's TOML file.

    Raises:
        BadFile: If one is wrong; the message names the key.
    """
    return experiment_from(read_toml(path), path)


def kept_experiment(directory: Path) -> Experiment | None:
    """The settings under which people took part in a study; None where none are stored. Raises BadFile if damaged."""
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    return experiment_from(parse_json(read_input(path), path), path) if is_there(path) else None


def first_error(error: ValidationError, model: type[BaseModel]) -> str:
    """The first mistake that pydantic found in what should have been a ``model``: where, what came, what is allowed."""
    first = error.errors()[0]
    where = ".".join(map(str, first["loc"])) or "all"
    said = str(first["ctx"]["error"]) if first["type"] == "value_error" else plain(first["msg"])
    if first["type"] == "extra_forbidden" and len(first["loc"]) == 1:
        return f"{where}: {UnknownName('key', where, model.model_fields)}"
    if first["type"] != "value_error" and said.startswith("expected "):
        return str(BadValue(where, first["input"], said.removeprefix("expected ")))
    return f"{where}: {said}"
