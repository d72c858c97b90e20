"""The first sentence of a page that answers two questions: what false reports did, and what other conditions did."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.effects import Effects
from lockprobe.analysis.inference.logrank import holm
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.summary import StudySummary
from lockprobe.formatting import p_cell
from lockprobe.prose.overview import effects_answer, flips_answer

__all__ = ["both_answers"]


def both_answers(flips: StudySummary, found: Sequence[Effects]) -> str:
    """What false reports and what other conditions did: two questions, each with a family of tests of its own.

    One screen that answers both is false if one answer is. So a change is said here if it is detected after correction
    for both questions (Holm); the sections keep the P values of their own family.
    """
    agents = [agent.contrast.difference.p_value for agent in flips.subjects if agent.contrast]
    conditions = [one.difference.p_value for own in found for one in own.effects]
    values = [min(own, default=None) for own in (agents, conditions)]
    said = []
    for answer, of, value, corrected in zip(
        (flips_answer(flips), effects_answer(found, other=True)),
        ("false reports", "other conditions"),
        values,
        holm(values),
        strict=True,
    ):
        lost = value is not None and corrected is not None and value < ALPHA <= corrected
        said.append(
            f"An effect of {of} was detected in its own section (P = {p_cell(value)}), but not after correction for "
            "both questions of this page."
            if lost
            else answer
        )
    return " ".join(said)
