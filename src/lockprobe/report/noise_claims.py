"""The paper's claims about success over p (Sec. 3.2, Fig. 4), compared with what a study measured."""

from __future__ import annotations

import math
from collections.abc import Mapping

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.inference.difference import DifferenceAt
from lockprobe.analysis.proportions import ALPHA, Proportion, difference, ratio
from lockprobe.analysis.published import PEAK, SOLVED_AT_0, SOLVED_AT_40
from lockprobe.analysis.summary import AgentSummary
from lockprobe.formatting import minus
from lockprobe.report.claim_tests import (
    NOT_MEASURED,
    ClaimFinding,
    ClaimMeasure,
    ClaimPattern,
    apart,
    borne_out,
    error,
    in_points,
    pattern,
    same_share,
    verdict_of,
)

__all__ = ["NOISE_MEASURES"]


def _told_the_truth(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    return same_share(counted[0].success, SOLVED_AT_0)


def _at_peak(counted: list[ConditionSummary]) -> ConditionSummary | None:
    return next((condition for condition in counted if math.isclose(condition.p, PEAK)), None)


def _rise(agent: AgentSummary) -> tuple[ClaimPattern, DifferenceAt | None]:
    """Whether success at the paper's peak is shown to be above that at p = 0, corrected for looking at every p."""
    found = next((at for at in agent.inference.difference.at if math.isclose(at.p, PEAK)), None)
    return (pattern(found.p_value, found.value), found) if found else ("open", None)


def _peak(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Success rises to p = 0.4, and no other p is shown to be better."""
    candidates, other = agent.peak.candidates, _at_peak(counted)
    inside = next((candidate.in_set for candidate in candidates if math.isclose(candidate.p, PEAK)), None)
    if agent.blind or len(candidates) < 2 or inside is None or other is None or agent.peak.best is None:
        return NOT_MEASURED
    change = counted[0].success, other.success
    rise = difference(*change)
    assert rise is not None
    among = ", ".join(f"{candidate.p:g}" for candidate in candidates if candidate.in_set)
    here = f"highest at {agent.peak.best:g}; 95 % set {among}; from 0 to 0.4 {in_points(rise)}"
    shown, at = _rise(agent)
    if not inside:
        return here, "not compatible", "95 % bootstrap set of the best flip rate", None
    if shown != "open" and at:
        return here, verdict_of(None, shown), "permutation test, corrected for all flip rates", at.p_value
    published = SOLVED_AT_40.value - SOLVED_AT_0.value
    p_value = apart(rise.value, published, [error(change), error((SOLVED_AT_0, SOLVED_AT_40))])
    smaller: ClaimPattern = "opposite" if rise.value < published and p_value < ALPHA else "open"
    test = f"no rise was detected; z test against the paper's rise of {100 * published:.0f} points"
    return here, verdict_of(None, smaller), test, p_value


def _ratio(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Success rises from 0 to 0.4, and as many times as in the paper."""
    other = _at_peak(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    first, second = counted[0].success, other.success
    found = ratio(first, second)
    (here, error_here), (paper, error_paper) = _log_ratio(first, second), _log_ratio(SOLVED_AT_0, SOLVED_AT_40)
    p_value = apart(here, paper, [error_here, error_paper])
    said = f"{second.count}/{second.n} at 0.4 over {first.count}/{first.n} at 0"
    if found:
        said += f": {found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"
    shown, _ = _rise(agent)
    rise = {"shown": "a rise was detected", "opposite": "a fall was detected", "open": "no rise was detected"}[shown]
    test = "z test of the log ratios, with half a trial added to each count"
    return said, verdict_of(p_value, shown), f"{test}; {rise}", p_value


def _log_ratio(first: Proportion, second: Proportion) -> tuple[float, float]:
    """The logarithm of a ratio of shares, second over first, and its standard error (Walter 1975)."""
    shares = [((share.count + 0.5), (share.n + 0.5)) for share in (second, first)]
    (a, n), (b, m) = shares
    return math.log(a / n) - math.log(b / m), math.sqrt(1 / a - 1 / n + 1 / b - 1 / m)


def _effect(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Success is above that at p = 0 for some p; the opposite is a fall at the paper's moderate noise, 0.4."""
    found = agent.inference.difference.at
    if agent.blind or not found:
        return NOT_MEASURED
    rises = [at for at in found if pattern(at.p_value, at.value) == "shown"]
    shown, moderate = _rise(agent)
    if rises:
        shown, moderate = "shown", min(rises, key=lambda at: (at.p_value, -at.value))
    at = moderate or max(found, key=lambda at: at.value)
    here = minus(f"{100 * at.value:+.0f} points from 0 to {at.p:g}")
    return here, borne_out(shown), "permutation test, corrected for all flip rates", at.p_value


def _shape(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Success rises and falls again, as the sentence goes on; a fall and a rise are the opposite."""
    lines = agent.inference.lines
    if lines.p_value is None or agent.blind:
        return NOT_MEASURED
    said = "" if lines.break_p is None else f"the lines meet at {lines.break_p:.2f}"
    sign = {"inverted U": 1, "U": -1, None: 0}[lines.direction]
    return said, borne_out(pattern(lines.p_value, sign)), "two lines", lines.p_value


NOISE_MEASURES: Mapping[str, ClaimMeasure] = {
    "baseline": _told_the_truth,
    "peak": _peak,
    "ratio": _ratio,
    "effect": _effect,
    "shape": _shape,
}
"""What measures a claim about success over p."""
