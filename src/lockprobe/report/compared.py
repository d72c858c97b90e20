"""A figure of the paper beside one of this study: can a test tell them apart?"""

from __future__ import annotations

import math
from typing import Literal

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.proportions import ALPHA, Proportion, difference
from lockprobe.report.paper import share

__all__ = ["NOT_MEASURED", "Found", "Verdict", "same_share", "same_step", "verdict_of"]

Verdict = Literal["compatible", "not compatible", "not borne out", "borne out", "not measured"]
"""*Compatible*: the test named cannot tell the paper's figure and ours apart, which may only mean few trials.
*Borne out* or not: a valid test in this study of what the claim suggests, for claims that are no figure."""

Found = tuple[str, Verdict, str, float | None]
"""What was measured, in words; the verdict; what it rests on; its p-value, where it has one."""

NOT_MEASURED: Found = ("", "not measured", "", None)


def verdict_of(p_value: float | None) -> Verdict:
    """Whether two figures can be told apart."""
    return "not compatible" if p_value is not None and p_value < ALPHA else "compatible"


def same_share(here: Proportion, paper: Proportion) -> Found:
    """A share against one of the paper's."""
    found = difference(paper, here)
    p_value = found.p_value if found else None
    return share(here), verdict_of(p_value), f"Fisher, against {paper.count}/{paper.n}", p_value


def same_step(here: ConditionSummary, paper: int) -> Found:
    """The step by which 80 % of the trials are solved against the paper's."""
    curve = here.curve
    reached, (early, late) = curve.steps_to(0.8), curve.steps_to_interval(0.8)
    inside = (early or math.inf) <= paper <= (late or math.inf)
    said = f"80 % by step {_step(reached)} [{_step(early)}, {_step(late)}]"
    return said, "compatible" if inside else "not compatible", "95 % interval of the step, from the band", None


def _step(step: int | None) -> str:
    return "not reached" if step is None else str(step)
