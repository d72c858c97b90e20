"""What an experimenter writes for people: settings (``people.toml``), and the texts of each language, consent included.

Neither changes a trial that models play.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from lockprobe.foundation.errors import UnknownName
from lockprobe.foundation.inputs import is_there, parse_json, read_input, read_toml
from lockprobe.foundation.validation import Written, validated
from lockprobe.studies import PEOPLE_DIRECTORY

EXPERIMENT = "experiment.json"
"""The file of these settings, in the directory of people."""


Text = Annotated[str, Field(min_length=1, max_length=4000)]
Option = Annotated[str, Field(min_length=1, max_length=200)]
Options = Annotated[tuple[Option, ...], Field(max_length=20)]
Url = Annotated[str, Field(pattern=r"^(https://\S{1,2000})?$")]
Code = Annotated[str, Field(max_length=100)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,39}$")]


class Question(Written):
    """A question: one of the options is chosen; without options the answer is written."""

    question: Text
    options: Options = ()
    required: bool = True

    def takes(self, given: str) -> bool:
        """Whether an answer is acceptable; an empty one leaves the question out."""
        if not given.strip():
            return not self.required
        return given in self.options or not self.options


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


class Experiment(Written):
    """How people take part. The example that ``lockprobe serve --write-people FILE`` writes explains each setting.

    None for ``trials_each`` is each condition once, for ``participants`` as many as the study has trials for.
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


def read_experiment(path: Path) -> Experiment:
    """The settings in a user's TOML file. Raises BadFile if one is wrong."""
    return validated(Experiment, read_toml(path), path)


def kept_experiment(directory: Path) -> Experiment | None:
    """The settings under which people took part in a study; None where none are stored. Raises BadFile if damaged."""
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    return validated(Experiment, parse_json(read_input(path), path), path) if is_there(path) else None


_TEXTS = Path(__file__).with_name("texts")

LANGUAGES = tuple(sorted(path.stem for path in _TEXTS.glob("*.toml")))
"""The shipped languages."""

TEXTS = "texts.toml"
"""The copy of the texts, in the directory of people."""

Paragraphs = Annotated[tuple[Text, ...], Field(max_length=40)]


class Longer(Written):
    """A title and what stands under it.

    Attributes:
        if_false: More paragraphs, where what is told or shown can be false. Only an end admits it.
        if_asked: More paragraphs, where the page asks after every step what the last action did.
        questions: What is asked under them, on the instructions.
    """

    title: Text
    paragraphs: Paragraphs
    if_false: Paragraphs = ()
    if_asked: Paragraphs = ()
    questions: Annotated[tuple[OneRight, ...], Field(max_length=20)] = ()


class Words(Written):
    """Everything that a participant reads.

    ``language`` is a BCP 47 tag for screen readers, ``page`` the buttons, labels and sentences of reports, ``changes``
    what a study did to people (:data:`~lockprobe.people.scenes.Deception`), ``closed`` the last scene of who cannot
    go on, by why (:data:`~lockprobe.people.scenes.Why`). Each other field is a scene.
    """

    language: Annotated[str, Field(pattern=r"^[A-Za-z]{2,8}(-[A-Za-z0-9]{1,8})*$")]
    direction: Literal["ltr", "rtl"] = "ltr"
    title: Text
    consent: Longer
    instructions: Annotated[tuple[Longer, ...], Field(max_length=20)] = ()
    comprehension: Longer
    practice_over: Longer
    over: Longer
    debrief: Longer
    changes: dict[str, Text]
    closed: dict[str, Longer]
    page: dict[str, Text]

    @model_validator(mode="after")
    def _as_in_english(self) -> Self:
        english: dict[str, Any] = read_toml(_TEXTS / "en.toml")
        for part, given in (("page", self.page), ("changes", self.changes), ("closed", self.closed)):
            if missing := english[part].keys() - given.keys():
                raise ValueError(f"{part}: {min(missing)} is missing")
            if other := given.keys() - english[part].keys():
                raise ValueError(str(UnknownName(f"key in {part}", min(other), english[part])))
        return self

    @property
    def fingerprint(self) -> str:
        """Language and fingerprint, for example ``en 3f9a01bc22d1``."""
        known = json.dumps(self.model_dump(mode="json"), sort_keys=True)
        return f"{self.language} {hashlib.sha256(known.encode()).hexdigest()[:12]}"


def filled(text: str, **facts: object) -> str:
    """A text with its ``{names}`` filled in; unknown names stay as they are.

    >>> filled("Step {step} of {budget} {x}", step=1, budget=20)
    'Step 1 of 20 {x}'
    """
    return re.sub(r"\{(\w+)\}", lambda found: str(facts.get(found[1], found[0])), text)


def read_words(name: str) -> Words:
    """The texts of a shipped language such as ``en``, or of a TOML file.

    Raises:
        UnknownName: If the language does not exist.
        BadFile: If a text is missing or wrong; the message says which.
    """
    path = words_file(name)
    return validated(Words, read_toml(path), path)


def words_file(name: str) -> Path:
    """The path of a shipped language's texts or of a file, whether it exists or not."""
    if name.endswith(".toml") or "/" in name:
        return Path(name)
    if name in LANGUAGES:
        return _TEXTS / f"{name}.toml"
    raise UnknownName("language", name, [*LANGUAGES, "FILE.toml"])
