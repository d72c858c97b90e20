"""The first sentence of a page that answers several questions: what false reports, another dose and conditions did."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from lockprobe.foundation.formatting import listed, p_cell
from lockprobe.foundation.grouping import grouped
from lockprobe.report.prose.doses import cause
from lockprobe.report.prose.first_screen import baselines_answer, effects_answer, flips_answer, heeding_baselines
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.contrast import CONTROLS, Effects
from lockprobe.statistics.inference.holm import holm
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.summary import StudySummary


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """One question of a page, with a family of tests of its own.

    Attributes:
        about: What may have an effect.
        answer: What it did, in sentences, by the number of questions that its P values are corrected for.
        corrected: Whether these sentences name only what is detected after this correction.
        tested: What was tested, as it follows "the effect", and its P value, corrected within its family.
        baselines: Whether it is about baselines.
    """

    about: str
    answer: Callable[[int], str]
    tested: tuple[tuple[str, float], ...]
    corrected: bool = False
    baselines: bool = False

    @property
    def p_value(self) -> float | None:
        """The smallest P value of its family; None if nothing was tested."""
        return min((p_value for _, p_value in self.tested), default=None)


def of_axis(summary: StudySummary) -> list[Question]:
    """What false reports, or another dose, did: one question in each modality where it was tested.

    Baselines that heed reports are one more question, which is answered where something was detected.
    """
    tested = dict.fromkeys(agent.modality for agent in summary.subjects if agent.contrast)
    if len(tested) < 2:
        return [_of_axis(summary), *_of_baselines(summary)]
    agents = [tuple(one for one in summary.subjects if one.modality == modality) for modality in tested]
    return [*(_of_axis(replace(summary, agents=own)) for own in agents), *_of_baselines(summary)]


def _of_axis(summary: StudySummary) -> Question:
    return Question(
        about=_about(summary, summary.subjects),
        answer=lambda many: flips_answer(summary),
        tested=_tested(summary.subjects),
    )


def _of_baselines(summary: StudySummary) -> list[Question]:
    """What it did to baselines that heed reports; nothing where all agents are baselines, or none of them heeds."""
    own = heeding_baselines(summary)
    answer = Question(
        about=_about(summary, own),
        answer=lambda many: baselines_answer(summary),
        tested=_tested(own),
        baselines=True,
    )
    return [answer] if own else []


def _about(summary: StudySummary, agents: Sequence[AgentSummary]) -> str:
    shown = next((f" with {spoken(one.modality)}" for one in agents if one.contrast and one.shown), "")
    return f"{cause(summary.axis)}{shown}"


def _tested(agents: Sequence[AgentSummary]) -> tuple[tuple[str, float], ...]:
    return tuple((f"on {subject_of(one).name}", one.contrast.difference.p_value) for one in agents if one.contrast)


def of_conditions(found: Sequence[Effects], *, other: bool) -> list[Question]:
    """What conditions did that are levels of no axis: one question for each family.

    Args:
        found: The effects on the agents that the study is about.
        other: Whether there are conditions beside them.
    """
    families = grouped(found, lambda one: (one.family, one.control))
    several = len({control for family, control in families if family != CONTROLS}) > 1
    return [
        _of_family(own, other=other, shown=spoken(own[0].modality) if several else "") for own in families.values()
    ] or [_of_family((), other=other)]


def _of_family(found: Sequence[Effects], *, other: bool, shown: str = "") -> Question:
    several = len(found) > 1
    tested = [
        (f"of {one.condition}" + f" on {Subject.of(own.agent).name}" * several, one.difference.p_value)
        for own in found
        for one in own.effects
    ]
    return Question(
        about="the modality"
        if found and found[0].family == CONTROLS
        else f"other conditions{shown and f' with {shown}'}",
        answer=lambda many: effects_answer(found, other=other, shown=shown, many=many),
        tested=tuple(tested),
        corrected=True,
    )


def several_answers(questions: Sequence[Question]) -> str:
    """The answers of a page, one after the other.

    One screen that answers several questions is false if one answer is. So a change is said here if it is detected
    after correction for all of them (Holm); the sections keep the P values of their own family. Baselines are judged
    apart, as in the sections: what they do takes nothing from what is said of the agents that the study is about.
    """
    said = {id(one): answer for apart in (False, True) for one, answer in _answers(questions, baselines=apart)}
    return " ".join(dict.fromkeys(filter(None, (said[id(one)] for one in questions))))


def _answers(questions: Sequence[Question], *, baselines: bool) -> Iterator[tuple[Question, str]]:
    """Each of the questions about baselines, or about the others, with its answer."""
    own = [one for one in questions if one.baselines == baselines]
    every = "both" if len(own) == 2 else f"all {len(own)}"
    after = f"after correction for {every} questions of this page"
    for one, corrected in zip(own, holm([one.p_value for one in own]), strict=True):
        if one.p_value is not None and corrected is not None and one.p_value < ALPHA <= corrected:
            p_value = p_cell(one.p_value)
            lost = f"An effect of {one.about} was detected in its own section (P = {p_value}), but not {after}."
            yield one, "" if baselines else lost
            continue
        many = _many(one, own)
        answer, names = one.answer(many), [name for name, p in one.tested if p < ALPHA <= p * many]
        if answer and names:
            which = "The effect" if one.corrected else "Of these, the effect"
            found = "detected in its own section, but not" if one.corrected else "not detected"
            answer = f"{answer} {which} {listed(names, named=3)} was {found} {after}."
        yield one, answer


def _many(one: Question, questions: Sequence[Question]) -> int:
    """For how many questions it is corrected: those whose effects are no clearer."""
    p_values = [other.p_value for other in questions if other.p_value is not None]
    return max(1, sum(p_value >= (one.p_value or 0.0) for p_value in p_values))
