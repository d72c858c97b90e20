"""The texts that participants read, consent included, from a TOML file for each language."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.inputs import read_toml
from lockprobe.people.experiment import OneRight, SettingsPart, first_error

_TEXTS = Path(__file__).with_name("texts")

LANGUAGES = tuple(sorted(path.stem for path in _TEXTS.glob("*.toml")))
"""The shipped languages."""

TEXTS = "texts.toml"
"""The copy of the texts, in the directory of people."""

Text = Annotated[str, Field(min_length=1, max_length=4000)]
Paragraphs = Annotated[tuple[Text, ...], Field(max_length=40)]


class ComprehensionQuestion(OneRight):
    """A question on the instructions; with ``only`` it is asked where they say that reports can be wrong."""

    only: Literal["false_reports"] | None = None


class Longer(SettingsPart):
    """A title and what stands under it.

    Attributes:
        if_false: More paragraphs: of instructions, where the study says beforehand that reports can be wrong; of the
            end, where what was told or shown could be false.
        if_asked: More paragraphs, where the page asks after every step what the last action did.
        questions: What is asked under them, on the instructions.
    """

    title: Text
    paragraphs: Paragraphs
    if_false: Paragraphs = ()
    if_asked: Paragraphs = ()
    questions: Annotated[tuple[ComprehensionQuestion, ...], Field(max_length=20)] = ()


class Words(SettingsPart):
    """Everything that a participant reads.

    ``language`` is a BCP 47 tag for screen readers, ``page`` the buttons, labels and sentences of reports, ``changes``
    what a study did to people (:data:`~lockprobe.people.deceptions.Deception`), ``closed`` the last scene of who cannot
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
    try:
        return Words.model_validate(read_toml(path))
    except ValidationError as error:
        raise BadFile(path, first_error(error, Words)) from None


def words_file(name: str) -> Path:
    """The path of a shipped language's texts or of a file, whether it exists or not."""
    if name.endswith(".toml") or "/" in name:
        return Path(name)
    if name in LANGUAGES:
        return _TEXTS / f"{name}.toml"
    raise UnknownName("language", name, [*LANGUAGES, "FILE.toml"])
