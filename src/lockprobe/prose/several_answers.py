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
from lockprobe.prose.subject import Subject, subject_of

__all__ = ["Question", "of_axis", "of_conditions", "several_answers"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """One question of a page, with a family of tests of its own.

    Attributes:
        about: What may have an effect.
        answer: What it did, in sentences.
        tested: What was tested, as it follows "the effect", and its P value, corrected within its family.
    """

    about: str
    answer: str
    tested: tuple[tuple[str, float], ...]

    @property
    def p_value(self) -> float | None:
        """The smallest P value of its family; None if nothing was tested."""
        return min((p_value for _, p_value in self.tested), default=None)


def of_axis(summary: StudySummary) -> list[Question]:
    """What false reports, or another dose, did: one question in each modality where it was tested."""
    tested = dict.fromkeys(agent.modality for agent in summary.subjects if agent.contrast)
    if len(tested) < 2:
        return [_of_axis(summary)]
    agents = [tuple(one for one in summary.subjects if one.modality == modality) for modality in tested]
    return [_of_axis(replace(summary, agents=own)) for own in agents]


def _of_axis(summary: StudySummary) -> Question:
    tested = {subject_of(one): one.contrast for one in summary.subjects if one.contrast}
    shown = next((f" with {spoken(one.modality)}" for one in summary.subjects if one.contrast and one.shown), "")
    return Question(
        about=f"{cause(summary.axis)}{shown}",
        answer=flips_answer(summary),
        tested=tuple((f"on {who.name}", one.difference.p_value) for who, one in tested.items()),
    )


def of_conditions(found: Sequence[Effects], *, other: bool) -> Question:
    """What conditions did that are levels of no axis; ``other`` if there are conditions beside them."""
    several = len(found) > 1
    tested = [
        (f"of {one.condition}" + f" on {Subject.of(own.agent).name}" * several, one.difference.p_value)
        for own in found
        for one in own.effects
    ]
    return Question(about="other conditions", answer=effects_answer(found, other=other), tested=tuple(tested))


def several_answers(questions: Sequence[Question]) -> str:
    """The answers of a page, one after the other.

    One screen that answers several questions is false if one answer is. So a change is said here if it is detected
    after correction for all of them (Holm); the sections keep the P values of their own family.
    """
    every = "both" if len(questions) == 2 else f"all {len(questions)}"
    after = f"after correction for {every} questions of this page"
    said = []
    for one, corrected in zip(questions, holm([one.p_value for one in questions]), strict=True):
        if one.p_value is not None and corrected is not None and one.p_value < ALPHA <= corrected:
            p_value = p_cell(one.p_value)
            said.append(f"An effect of {one.about} was detected in its own section (P = {p_value}), but not {after}.")
            continue
        said.append(one.answer)
        if lost := _lost(one, questions):
            said.append(f"Of these, the effect {', '.join(lost)} was not detected {after}.")
    return " ".join(dict.fromkeys(said))


def _lost(one: Question, questions: Sequence[Question]) -> list[str]:
    """What is detected in its section, but not after correction for the questions whose effects are no clearer."""
    p_values = [other.p_value for other in questions if other.p_value is not None]
    many = sum(p_value >= (one.p_value or 0.0) for p_value in p_values)
    return [name for name, p_value in one.tested if p_value < ALPHA <= p_value * many]
