"""Questions with one right answer, and which of them a participant gets after the instructions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from lockprobe.people.file_errors import check_visible


class SettingsPart(BaseModel):
    """Base of what an experimenter writes into a file: immutable, and without unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _bare(text: str) -> str:
    """Refuse surrounding space: it is invisible, and would make another option."""
    if text != check_visible(text).strip():
        raise ValueError(f"got {text!r}, expected words without space around them")
    return text


Text = Annotated[str, Field(min_length=1, max_length=2000), AfterValidator(_bare)]
Option = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_bare)]
Options = Annotated[tuple[Option, ...], Field(max_length=20)]


class OneRight(SettingsPart):
    """A question with options, one of which is right."""

    question: Text
    options: Annotated[Options, Field(min_length=2)]
    right: str

    @model_validator(mode="after")
    def _right_is_an_option(self) -> Self:
        if self.right not in self.options or len(set(self.options)) < len(self.options):
            raise ValueError("options must be distinct, and right must be one of them")
        return self


class ComprehensionQuestion(OneRight):
    """A question on the instructions.

    ``only`` is where it is asked: ``positions`` where reports tell the positions of joints, ``false_reports`` where the
    instructions say that reports can be wrong; None for everywhere.
    """

    only: Literal["positions", "false_reports"] | None = None


class Comprehension(SettingsPart):
    """The questions between the instructions and the first box. Wrong answers lead back to the instructions.

    Attributes:
        ask: Whether there are any.
        rounds: After how many rounds with a wrong answer the session ends; None for never.
        questions: Questions in place of those of the texts.
    """

    ask: bool = True
    rounds: Annotated[int, Field(ge=1, le=100)] | None = None
    questions: Annotated[tuple[ComprehensionQuestion, ...], Field(max_length=20)] = ()


def missed(questions: Sequence[ComprehensionQuestion], answers: Sequence[str]) -> tuple[str, ...]:
    """The questions that were answered wrong."""
    return tuple(one.question for one, answer in zip(questions, answers, strict=True) if answer != one.right)
