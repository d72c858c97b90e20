"""The texts that participants read, consent included, from a TOML file for each language."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.inputs import read_toml
from lockprobe.people.file_errors import check_visible, first_error
from lockprobe.people.right_answers import ComprehensionQuestion
from lockprobe.people.right_answers import SettingsPart as _Part

_TEXTS = Path(__file__).with_name("texts")

LANGUAGES = tuple(sorted(path.stem for path in _TEXTS.glob("*.toml")))
"""The shipped languages."""

TEXTS = "texts.toml"
"""The copy of the texts, next to the diaries."""

Text = Annotated[str, Field(min_length=1, max_length=4000), AfterValidator(check_visible)]
Paragraphs = Annotated[tuple[Text, ...], Field(max_length=40)]


class Longer(_Part):
    """A title and what stands under it."""

    title: Text
    paragraphs: Paragraphs


class _Instruction(Longer):
    """A page of instructions.

    Attributes:
        if_false: More paragraphs, where the study says beforehand that reports can be wrong.
        if_asked: More paragraphs, where the page asks after every step what the last action did.
        if_at_zero: More paragraphs, where every box starts with all joints at 0 and reports tell positions.
        if_start_seen: More paragraphs, where it starts otherwise, or where pictures show positions.
        example: The example box: ``box`` before the first step, ``step`` after one with its report and the question, or
            ``none``. If left out, :func:`example_on` decides.
    """

    if_false: Paragraphs = ()
    if_asked: Paragraphs | None = None
    if_at_zero: Paragraphs = ()
    if_start_seen: Paragraphs = ()
    example: Literal["box", "step", "none"] | None = None


class _Comprehension(Longer):
    """The page of questions on the instructions.

    ``again`` is said at the top of the instructions after wrong answers, and names their ``{questions}``.
    """

    again: Text
    questions: Annotated[tuple[ComprehensionQuestion, ...], Field(max_length=20)] = ()

    @model_validator(mode="after")
    def _one_is_always_asked(self) -> Self:
        if self.questions and all(one.only for one in self.questions):
            raise ValueError("expected a question without only")
        return self


class _Consent(Longer):
    agree: Text
    decline: Text


class _Over(Longer):
    solved: Text
    unsolved: Text


class _Debrief(Longer):
    false_reports: Paragraphs
    completion: Text
    code: Text


class _Changes(_Part):
    """What a study did to reports and attempts, by :data:`~lockprobe.people.deceptions.Deception`."""

    false: Text
    late: Text
    another: Text
    warned: Text
    changed: Text


class _Closed(_Part):
    false_reports: Paragraphs
    declined: Longer
    withdrawn: Longer
    full: Longer
    taken: Longer
    finished: Longer
    late: Longer
    screened: Longer


class PageWords(_Part):
    """Buttons, labels, and the sentences of reports."""

    next: Text
    begin: Text
    send: Text
    skip: Text
    step: Text
    box: Text
    practice: Text
    practice_ends: Text | None = None  # texts of an earlier release, which people read on, have none
    choose: Text
    joint: Text
    target: Text
    slides: Text
    turns: Text
    position: Text
    unknown_position: Text
    first: Text
    moved: Text
    blocked: Text
    now: Text
    positions: Text
    none: Text
    no_report: Text
    seen: Text
    colours: Text
    depth: Text
    question: Text
    said_moved: Text
    said_blocked: Text
    history: Text
    waiting: Text
    offline: Text
    elsewhere: Text
    here: Text
    withdraw: Text
    withdraw_sure: Text
    withdraw_yes: Text
    withdraw_no: Text
    refused: Text
    incomplete: Text
    reload: Text
    required: Text
    all_required: Text
    progress: Text
    code: Text
    wrong_code: Text
    attempted: Text
    number: Text
    integer: Text
    closed_code: Text
    closed_leave: Text
    example: Text
    example_step: Text
    example_some: Text
    example_panel: Text
    example_pictures: Text
    example_depth: Text
    example_positions: Text


class Words(_Part):
    """Everything that a participant reads.

    ``language`` is a BCP 47 tag for screen readers, ``page`` the buttons and labels. Each other field is a scene.
    """

    language: Annotated[str, Field(pattern=r"^[A-Za-z]{2,8}(-[A-Za-z0-9]{1,8})*$")]
    direction: Literal["ltr", "rtl"] = "ltr"
    title: Text
    consent: _Consent
    instructions: Annotated[tuple[_Instruction, ...], Field(max_length=20)] = ()
    comprehension: _Comprehension
    practice_over: Longer
    over: _Over
    debrief: _Debrief
    changes: _Changes
    closed: _Closed
    page: PageWords


def filled(text: str, **facts: object) -> str:
    """A text with its ``{names}`` filled in; unknown names stay as they are.

    >>> filled("Step {step} of {budget} {x}", step=1, budget=20)
    'Step 1 of 20 {x}'
    """
    return re.sub(r"\{(\w+)\}", lambda found: str(facts.get(found[1], found[0])), text)


def example_on(words: Words, number: int) -> Literal["box", "step", "none"]:
    """The example box on a page of instructions, from 1.

    By default the first page shows the box and the second a step; a single page shows a step.
    """
    pages = words.instructions
    if (said := pages[number - 1].example) is not None:
        return said
    if number == 1 and len(pages) > 1:
        return "box"
    return "step" if number <= 2 else "none"


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
    """The path of a shipped language's texts or of a file, whether it exists or not.

    Raises:
        UnknownName: If the language does not exist.
    """
    if name.endswith(".toml") or "/" in name:
        return Path(name)
    if name in LANGUAGES:
        return _TEXTS / f"{name}.toml"
    raise UnknownName("language", name, [*LANGUAGES, "FILE.toml"])
