"""Tests of a figure or a pattern of the paper against this study, and the verdict on the claim as a whole."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import Literal

from lockprobe.foundation.formatting import minus, points
from lockprobe.report.claims.paper import counted_share
from lockprobe.report.prose.hypothesis_tests import effect_said
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.clustered import ClusteredProportion
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.proportions import ALPHA, Difference, Proportion, difference

ClaimVerdict = Literal["compatible", "not compatible", "borne out", "not decided", "not measured"]
"""*Compatible*: no difference from the paper's value was detected, which may only mean few trials, and the study shows
the pattern of the claim. *Borne out*: the study shows the pattern of a claim without a value. *Not compatible*: a test
contradicts the value or the pattern. *Not decided*: neither."""

ClaimPattern = Literal["shown", "opposite", "open"]
"""What a valid test says of the pattern that a claim describes: it shows it, or the opposite, or neither."""

ClaimFinding = tuple[str, ClaimVerdict, str, float | None]
"""What was measured, in words; the verdict; what it rests on; its p-value, where it has one.

What it rests on begins with the test that the p-value is of; what else is said follows a semicolon.
"""

ClaimMeasure = Callable[[AgentSummary, Sequence[ConditionSummary]], ClaimFinding]
"""What an agent says to a claim by its conditions with trials, ascending from p = 0."""

NOT_MEASURED: ClaimFinding = ("", "not measured", "", None)


def verdict_of(p_value: float | None, also: ClaimPattern = "shown") -> ClaimVerdict:
    """On a claim of a figure and a pattern, from the test that may tell the two figures apart."""
    if also == "opposite" or (p_value is not None and p_value < ALPHA):
        return "not compatible"
    return "compatible" if also == "shown" else "not decided"


def borne_out(found: ClaimPattern) -> ClaimVerdict:
    """On a claim that is a pattern and no figure."""
    return "borne out" if found == "shown" else "not compatible" if found == "opposite" else "not decided"


def above_half(found: Proportion | ClusteredProportion) -> ClaimVerdict:
    """On a claim of *most*: whether the interval of the share lies above or below one half."""
    return borne_out("shown" if found.low > 0.5 else "opposite" if found.high < 0.5 else "open")


def pattern(p_value: float | None, direction: float) -> ClaimPattern:
    """From a two-sided test, where a positive direction is that of the claim."""
    if p_value is None or p_value >= ALPHA or not direction:
        return "open"
    return "shown" if direction > 0 else "opposite"


def same_share(here: Proportion, paper: Proportion) -> ClaimFinding:
    """A share against one of the paper's."""
    found = difference(paper, here)
    p_value = found.p_value if found else None
    return counted_share(here), verdict_of(p_value), f"Fisher, against {paper.count}/{paper.n}", p_value


def same_step(here: ConditionSummary, paper: int) -> ClaimFinding:
    """The step by which 80 % of the trials are solved against the paper's."""
    early, late = here.curve.steps_to_interval(0.8)
    inside = (early or math.inf) <= paper <= (late or math.inf)
    step, *ends = ("not reached" if one is None else str(one) for one in (here.curve.steps_to(0.8), early, late))
    said = f"80 % by step {step} [{', '.join(ends)}]"
    return said, "compatible" if inside else "not compatible", "95 % interval of the step, from the band", None


def apart(here: float, paper: float, errors: Sequence[float]) -> float:
    """Two-sided p-value of two independent estimates with these standard errors being of one truth."""
    return 2 * NormalDist().cdf(-abs(here - paper) / math.hypot(*errors))


def error(change: tuple[Proportion, Proportion]) -> float:
    """Standard error of a difference of shares with two more trials of each kind (Agresti and Coull)."""
    smooth = [((one.count + 2) / (one.n + 4), one.n + 4) for one in change]
    return math.sqrt(sum(value * (1 - value) / n for value, n in smooth))


def later_loops(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """The test of how soon an agent loops; the claim expects that it loops later."""
    (test,) = (t for t in agent.inference.tests if t.question == "looping")
    if test.p_value is None or agent.blind:
        return NOT_MEASURED
    said = "" if test.effect is None else minus(f"{test.effect:.2f} ({effect_said(test.name)})")
    return said, borne_out(pattern(test.p_value, -test.direction)), test.name, test.p_value


def in_points(found: Difference) -> str:
    """A difference of shares in percentage points, with its interval."""
    return f"{points(found.value)} points [{points(found.low)}, {points(found.high)}]"
