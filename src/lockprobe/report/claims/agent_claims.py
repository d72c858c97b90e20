"""The paper's claims about one agent (Secs. 3.1 to 3.3), compared with what a study measured over its flip rates.

Loop rates are compared as the paper compares them, over whole trials: shorter trials hold fewer loops by chance alone.
Claims about effects and onset of loops are compared with tests at equal steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from lockprobe.foundation.formatting import bracketed, percent, points, range_of
from lockprobe.foundation.formatting import p_value as p_value_said
from lockprobe.report.claims.claim_tests import (
    NOT_MEASURED,
    ClaimFinding,
    ClaimMeasure,
    ClaimPattern,
    above_half,
    apart,
    borne_out,
    error,
    in_points,
    later_loops,
    pattern,
    same_share,
    same_step,
    verdict_of,
)
from lockprobe.report.format import share_cell
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.distributions import welch_test
from lockprobe.statistics.inference.difference import DifferenceAt
from lockprobe.statistics.inference.logrank import holm
from lockprobe.statistics.inference.ushape import Line
from lockprobe.statistics.misinterpretation import Misinterpretations
from lockprobe.statistics.proportions import (
    ALPHA,
    Difference,
    Proportion,
    difference,
    opposed_shares,
    proportion,
    ratio,
)
from lockprobe.statistics.published import (
    CORRELATION,
    CORRELATION_POINTS,
    LOOPS_AT_0,
    LOOPS_AT_40,
    PEAK,
    REFERENCE,
    REFERENCE_STEPS,
    SOLVED_AT_0,
    SOLVED_AT_40,
    TABLE1,
    MisreadRate,
)

_NEAR = 0.1
"""How far a minimum "near 40 %" may lie from it: the next p of the paper."""

_DETECTED: Mapping[ClaimPattern, str] = {"shown": "a rise", "opposite": "a fall", "open": "no rise"}

_LOOPS: Mapping[ClaimPattern, str] = {
    "shown": "fewer loops at higher flip rates were detected",
    "opposite": "more loops at higher flip rates were detected",
    "open": "no change with the flip rate was detected",
}

_SIGN = {"inverted U": 1, "U": -1, None: 0}
"""Shape of two lines -> 1 if a rise comes before a fall."""


def _at_peak(counted: Sequence[ConditionSummary]) -> ConditionSummary | None:
    return next((condition for condition in counted if math.isclose(condition.dose, PEAK)), None)


def _rise(agent: AgentSummary) -> tuple[ClaimPattern, DifferenceAt | None]:
    """Whether success at the paper's peak is shown to be above that at p = 0, corrected for looking at every p."""
    found = next((at for at in agent.inference.difference.at if math.isclose(at.dose, PEAK)), None)
    return (pattern(found.p_value, found.value), found) if found else ("open", None)


def _peak(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """Success rises to p = 0.4 by as much as in the paper, and is nowhere shown to be higher."""
    other = _at_peak(counted)
    if agent.blind or len(counted) < 2 or other is None:
        return NOT_MEASURED
    change = counted[0].success, other.success
    rise = difference(*change)
    assert rise is not None
    here = f"from 0 to 0.4 {in_points(rise)}"
    above = [difference(other.success, one.success) for one in counted]
    if "shown" in _patterns([one for one in above if one], 1):
        return here, "not compatible", "Fisher, against every flip rate (Holm): higher at another", None
    shown, at = _rise(agent)
    if shown != "open" and at:
        return here, verdict_of(None, shown), "permutation test, corrected for all flip rates", at.p_value
    published = SOLVED_AT_40.value - SOLVED_AT_0.value
    p_value = _apart(change, (SOLVED_AT_0, SOLVED_AT_40), lambda one, two: (two.value - one.value, error((one, two))))
    smaller: ClaimPattern = "opposite" if rise.value < published and p_value < ALPHA else "open"
    test = f"z test against the paper's rise of {100 * published:.0f} points; no rise to 0.4 was detected"
    return here, verdict_of(None, smaller), test, p_value


def _ratio(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """Success rises from 0 to 0.4, and as many times as in the paper."""
    other = _at_peak(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    first, second = counted[0].success, other.success
    p_value = _apart((first, second), (SOLVED_AT_0, SOLVED_AT_40), _log_ratio)
    said = f"{second.count}/{second.n} at 0.4 over {first.count}/{first.n} at 0"
    if found := ratio(first, second):
        said += f": {bracketed(found.value, found.low, found.high, '{:.2f}', 1)}"
    shown, _ = _rise(agent)
    test = f"z test of the log ratios, with half a trial added to each count; {_DETECTED[shown]} to 0.4 was detected"
    return said, verdict_of(p_value, shown), test, p_value


def _apart(
    here: tuple[Proportion, Proportion],
    paper: tuple[Proportion, Proportion],
    of: Callable[[Proportion, Proportion], tuple[float, float]],
) -> float:
    """P value that what two shares give (a number and its standard error) is that of the paper's two shares.

    If trials broke, the larger of both ends, and 1 if the paper's lies between these.
    """
    published, paper_error = of(*paper)
    found = [of(*ends) for ends in opposed_shares(*here)]
    if len({value > published for value, _ in found}) > 1:
        return 1.0
    return max(apart(value, published, [own, paper_error]) for value, own in found)


def _log_ratio(first: Proportion, second: Proportion) -> tuple[float, float]:
    """The logarithm of a ratio of shares, second over first, and its standard error (Walter 1975)."""
    (a, n), (b, m) = ((share.count + 0.5, share.n + 0.5) for share in (second, first))
    return math.log(a / n) - math.log(b / m), math.sqrt(1 / a - 1 / n + 1 / b - 1 / m)


def _effect(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """Success is above that at p = 0 for some p; the opposite is a fall at the paper's moderate noise, 0.4."""
    found = agent.inference.difference.at
    if agent.blind or not found:
        return NOT_MEASURED
    rises = [at for at in found if pattern(at.p_value, at.value) == "shown"]
    shown, moderate = _rise(agent)
    if rises:
        shown, moderate = "shown", min(rises, key=lambda at: (at.p_value, -at.value))
    at = moderate or max(found, key=lambda at: at.value)
    here = f"{points(at.value)} points from 0 to {at.dose:g}"
    return here, borne_out(shown), "permutation test, corrected for all flip rates", at.p_value


def _shape(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """Success rises and falls again, as the sentence goes on; a fall and a rise are the opposite."""
    lines = agent.inference.lines
    if lines.p_value is None or agent.blind:
        return NOT_MEASURED
    said = "" if lines.break_p is None else f"the lines meet at {lines.break_p:.2f}"
    return said, borne_out(pattern(lines.p_value, _SIGN[lines.direction])), "two lines", lines.p_value


def _loops(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """As many trials loop at p = 0 as in the paper, and more than elsewhere."""
    behaviour = counted[0].behaviour
    found, _, test, p_value = same_share(behaviour.loops, LOOPS_AT_0)
    if behaviour.chance_uniform is not None and behaviour.chance_no_repeat is not None:
        found += f"; by chance {range_of(behaviour.chance_uniform, behaviour.chance_no_repeat)}"
    fewer = "open" if agent.blind else _fewer(counted)
    why = "loops of a blind agent cannot depend on reports" if agent.blind else _LOOPS[fewer]
    return found, verdict_of(p_value, fewer), f"{test}; {why}", p_value


def _change(first: ConditionSummary, second: ConditionSummary) -> Difference:
    found = difference(first.behaviour.loops, second.behaviour.loops)
    assert found is not None
    return found


def _fewer(counted: Sequence[ConditionSummary]) -> ClaimPattern:
    """Whether loops are rarer than at p = 0: at 0.4, where the paper has its minimum, and nowhere more frequent."""
    if "shown" in _patterns([_change(counted[0], condition) for condition in counted[1:]], 1):
        return "opposite"
    other = _at_peak(counted)
    drop = _change(counted[0], other) if other else None
    return pattern(drop.p_value, -drop.value) if drop else "open"


def _patterns(changes: Sequence[Difference], sign: int) -> list[ClaimPattern]:
    """Which changes are shown to have this sign, corrected for their number (Holm)."""
    adjusted = holm([change.p_value for change in changes])
    return [pattern(p, sign * change.value) for p, change in zip(adjusted, changes, strict=True)]


def _drop(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """Loops are rarer at 0.4 than at 0, by as much as in the paper, and not still rarer far from it."""
    other = _at_peak(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    drop, (first, second) = _change(counted[0], other), (counted[0].behaviour.loops, other.behaviour.loops)
    errors = [error((first, second)), error((LOOPS_AT_0, LOOPS_AT_40))]
    p_value = apart(drop.value, LOOPS_AT_40.value - LOOPS_AT_0.value, errors)
    far = [_change(other, condition) for condition in counted if abs(condition.dose - PEAK) > _NEAR + 1e-9]
    lower = "shown" in _patterns(far, -1)
    shown = "opposite" if lower else pattern(drop.p_value, -drop.value)
    said = f"{first.count}/{first.n} to {second.count}/{second.n}, {in_points(drop)}"
    why = "fewer loops were detected far from 0.4" if lower else _LOOPS[_fewer(counted)]
    return said, verdict_of(p_value, shown), f"z test of the two differences; {why}", p_value


def _onset(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """First loops come later and then sooner again; a first line that rises, or a second that falls, contradicts it."""
    lines = agent.inference.onset_lines
    if lines.p_value is None or lines.first is None or lines.second is None or agent.blind:
        return NOT_MEASURED
    said = f"hazard of a first loop {_slope(lines.first)} up to {lines.break_p:.2g}, {_slope(lines.second)} above"
    first, second = holm([lines.first.p_value, lines.second.p_value])
    against = (pattern(first, -lines.first.z), pattern(second, lines.second.z))
    refuted = agent.inference.broken is None and "opposite" in against
    shown = "opposite" if refuted else pattern(lines.p_value, -_SIGN[lines.direction])
    test = "loop onset, two lines; assumes that solved trials would have looped like the others"
    return said, borne_out(shown), test, lines.p_value


def _slope(line: Line) -> str:
    """How a line runs, with its p-value."""
    way = "rises" if line.z > 0 else "falls" if line.z < 0 else "is constant"
    return f"{way} ({p_value_said(line.p_value)})"


def _correlation(agent: AgentSummary, counted: Sequence[ConditionSummary]) -> ClaimFinding:
    """R is negative, and as large as in the paper."""
    found = agent.correlation
    if found.r is None or agent.blind or found.low is None or found.high is None or found.n < 4 or abs(found.r) == 1:
        return NOT_MEASURED
    errors = [1 / math.sqrt(n - 3) for n in (found.n, CORRELATION_POINTS)]
    p_value = apart(math.atanh(found.r), math.atanh(CORRELATION), errors)
    said = f"{bracketed(found.r, found.low, found.high, '{:.2f}', 1)} over {found.n} points"
    shown = pattern(found.p_value, -found.r)
    sign = {"shown": "r is negative", "opposite": "r is positive", "open": "no correlation was detected"}
    test = f"Fisher's z test; {sign[shown]}; neither value is evidence of harm by loops"
    return said, verdict_of(p_value, shown), test, p_value


def misread_measure(measure: str, said: Misinterpretations, modality: str) -> ClaimFinding:
    """What the claims of an agent about its actions say: misreadings occur as often as in the paper, or of which kind.

    Args:
        measure: ``misinterpretation`` or ``hallucination``.
        said: What the agent said of its actions.
        modality: How the box was shown, a row of Table 1.
    """
    paper, mean, sd = TABLE1[modality], said.mean_rate, said.sd_rate
    if mean is None or (sd is None and measure == "misinterpretation"):
        return NOT_MEASURED
    if not said.total:
        return _none(said, paper)
    if sd is None or measure == "hallucination":
        return _hallucinated(said)
    p_value = welch_test((paper.mean, paper.sd, paper.trials), (mean, sd, said.trials))
    affected = f"{said.total} in all, in {said.affected} of {said.trials} trials"
    here = f"{percent(mean, 1)} ± {percent(sd, 1)}, {affected}"
    return here, verdict_of(p_value), "Welch, on the rates per trial", p_value


def _none(said: Misinterpretations, paper: MisreadRate) -> ClaimFinding:
    """Not one misreading: in how many trials, and could that be chance if as many trials had one as in the paper?"""
    found = difference(proportion(paper.affected, paper.trials), proportion(0, said.trials))
    assert found is not None
    here = f"none in {said.pooled.n} claims of {said.trials} trials, at most {percent(said.misinterpreted.high, 1)}"
    test = f"Fisher, trials with a misreading, against {paper.affected}/{paper.trials}"
    return here, borne_out(pattern(found.p_value, -1)), test, found.p_value


def _hallucinated(said: Misinterpretations) -> ClaimFinding:
    """Most misreadings are of a joint that is said to have moved though it was reported blocked."""
    share, blocked, moved = said.hallucinated, said.moved_for_blocked, said.blocked_for_moved
    here = (
        f"{share.count} of {share.n} misreadings claim moved after a report of blocked, {share_cell(share)}; misread: "
    )
    here += f"{blocked.count} of {blocked.n} reports of blocked and {moved.count} of {moved.n} reports of moved"
    return here, above_half(share), "95 % interval above or below one half, clustered by trial", None


AGENT_MEASURES: Mapping[str, ClaimMeasure] = {
    "reference": lambda agent, counted: same_share(counted[0].success, REFERENCE),
    "reference-steps": lambda agent, counted: same_step(counted[0], REFERENCE_STEPS),
    "baseline": lambda agent, counted: same_share(counted[0].success, SOLVED_AT_0),
    "peak": _peak,
    "ratio": _ratio,
    "effect": _effect,
    "shape": _shape,
    "loops": _loops,
    "loops-drop": _drop,
    "loops-rise": _onset,
    "onset": later_loops,
    "correlation": _correlation,
}
"""What measures a claim over the flip rates of an agent."""
