"""The first sentence of a page that answers several questions: what false reports, another dose and conditions did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lockprobe.analysis.effects import Effects
from lockprobe.analysis.inference.logrank import holm
from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.summary import StudySummary
from lockprobe.formatting import p_cell
from lockprobe.prose.doses import cause
from lockprobe.prose.overview import effects_answer, flips_answer

__all__ = ["Question", "of_axis", "of_conditions", "several_answers"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """One question of a page, with a family of tests of its own.

    Attributes:
        about: What may have an effect.
        answer: What it did, in sentences.
        p_value: The smallest P value of its family, corrected within it; None if nothing was tested.
    """

    about: str
    answer: str
    p_value: float | None


def of_axis(summary: StudySummary) -> list[Question]:
    """What false reports, or another dose, did: one question in each modality where it was tested."""
    tested = dict.fromkeys(agent.modality for agent in summary.subjects if agent.contrast)
    if len(tested) < 2:
        return [_of_axis(summary, cause(summary.axis))]
    return [
        _of_axis(
            replace(summary, agents=tuple(one for one in summary.subjects if one.modality == modality)),
            f"{cause(summary.axis)} with {spoken(modality)}",
        )
        for modality in tested
    ]


def _of_axis(summary: StudySummary, about: str) -> Question:
    tested = [agent.contrast.difference.p_value for agent in summary.subjects if agent.contrast]
    return Question(about=about, answer=flips_answer(summary), p_value=min(tested, default=None))


def of_conditions(found: Sequence[Effects], *, other: bool) -> Question:
    """What conditions did that are levels of no axis; ``other`` if there are conditions beside them."""
    tested = [one.difference.p_value for own in found for one in own.effects]
    answer = effects_answer(found, other=other)
    return Question(about="other conditions", answer=answer, p_value=min(tested, default=None))


def several_answers(questions: Sequence[Question]) -> str:
    """The answers of a page, one after the other.

    One screen that answers several questions is false if one answer is. So a change is said here if it is detected
    after correction for all of them (Holm); the sections keep the P values of their own family.
    """
    every = "both" if len(questions) == 2 else f"all {len(questions)}"
    said = []
    for one, corrected in zip(questions, holm([one.p_value for one in questions]), strict=True):
        lost = one.p_value is not None and corrected is not None and one.p_value < ALPHA <= corrected
        said.append(
            f"An effect of {one.about} was detected in its own section (P = {p_cell(one.p_value)}), but not after "
            f"correction for {every} questions of this page."
            if lost
            else one.answer
        )
    return " ".join(dict.fromkeys(said))
