"""The paper's claims about loops (Sec. 3.3, Fig. 5), compared with what a study measured.

Loop rates are compared as the paper compares them, over whole trials: shorter trials hold fewer loops by chance alone.
Claims about effects and onset of loops are compared with tests at equal steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.inference.logrank import holm
from lockprobe.analysis.inference.ushape import Line
from lockprobe.analysis.persistence import VersusChance
from lockprobe.analysis.proportions import Difference, Proportion, difference
from lockprobe.analysis.published import CORRELATION, CORRELATION_POINTS, LOOPS_AT_0, LOOPS_AT_40, PEAK
from lockprobe.analysis.summary import AgentSummary
from lockprobe.formatting import minus
from lockprobe.formatting import p_value as p_value_said
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
    sized,
    tested,
    verdict_of,
)

__all__ = ["LOOP_MEASURES"]

_NEAR = 0.1
"""How far a minimum "near 40 %" may lie from it: the next p of the paper."""


def _loops(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """As many trials loop at p = 0 as in the paper, and more than elsewhere."""
    found, _, test, p_value = same_share(_rate(counted[0]), LOOPS_AT_0)
    chance = counted[0].behaviour
    if chance.chance_uniform is not None and chance.chance_no_repeat is not None:
        found += f"; by chance {100 * chance.chance_uniform:.0f} to {100 * chance.chance_no_repeat:.0f} %"
    if agent.blind:
        return found, verdict_of(p_value, "open"), f"{test}; loops of a blind agent cannot depend on reports", p_value
    fewer = _fewer(counted)
    return found, verdict_of(p_value, fewer), f"{test}; {_SAID[fewer]}", p_value


_SAID: Mapping[ClaimPattern, str] = {
    "shown": "fewer loops at higher flip rates were detected",
    "opposite": "more loops at higher flip rates were detected",
    "open": "no change with the flip rate was detected",
}


def _rate(condition: ConditionSummary) -> Proportion:
    return condition.behaviour.loops


def _change(first: ConditionSummary, second: ConditionSummary) -> Difference:
    found = difference(_rate(first), _rate(second))
    assert found is not None
    return found


def _fewer(counted: Sequence[ConditionSummary]) -> ClaimPattern:
    """Whether loops are rarer than at p = 0: at 0.4, where the paper has its minimum, and nowhere more frequent."""
    changes = [_change(counted[0], condition) for condition in counted[1:]]
    adjusted = holm([change.p_value for change in changes])
    if any(pattern(p, change.value) == "shown" for p, change in zip(adjusted, changes, strict=True)):
        return "opposite"
    other = _at_peak(counted)
    drop = _change(counted[0], other) if other else None
    return pattern(drop.p_value, -drop.value) if drop else "open"


def _at_peak(counted: Sequence[ConditionSummary]) -> ConditionSummary | None:
    return next((condition for condition in counted if math.isclose(condition.p, PEAK)), None)


def _drop(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Loops are rarer at 0.4 than at 0, by as much as in the paper, and not still rarer far from it."""
    other = _at_peak(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    drop, change = _change(counted[0], other), (_rate(counted[0]), _rate(other))
    p_value = apart(drop.value, LOOPS_AT_40.value - LOOPS_AT_0.value, [error(change), error((LOOPS_AT_0, LOOPS_AT_40))])
    far = [_change(other, condition) for condition in counted if abs(condition.p - PEAK) > _NEAR + 1e-9]
    lower = [pattern(p, -one.value) for p, one in zip(holm([one.p_value for one in far]), far, strict=True)]
    shown: ClaimPattern = "opposite" if "shown" in lower else pattern(drop.p_value, -drop.value)
    said = f"{change[0].count}/{change[0].n} to {change[1].count}/{change[1].n}, {in_points(drop)}"
    why = "fewer loops were detected far from 0.4" if "shown" in lower else _SAID[_fewer(counted)]
    return said, verdict_of(p_value, shown), f"z test of the two differences; {why}", p_value


def _rise(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """First loops come later and then sooner again; a first line that rises, or a second that falls, contradicts it."""
    lines = agent.inference.onset_lines
    if lines.p_value is None or lines.first is None or lines.second is None or agent.blind:
        return NOT_MEASURED
    said = f"hazard of a first loop {_slope(lines.first)} up to {lines.break_p:.2g}, {_slope(lines.second)} above"
    shown = pattern(lines.p_value, {"U": 1, "inverted U": -1, None: 0}[lines.direction])
    adjusted = holm([lines.first.p_value, lines.second.p_value])
    if agent.inference.broken is None and "opposite" in (
        pattern(adjusted[0], -lines.first.z),
        pattern(adjusted[1], lines.second.z),
    ):
        shown = "opposite"
    test = f"{sized('loop onset, two lines')}; assumes that solved trials would have looped like the others"
    return said, borne_out(shown), test, lines.p_value


def _slope(line: Line) -> str:
    """How a line runs, with its p-value."""
    way = "rises" if line.z > 0 else "falls" if line.z < 0 else "is constant"
    return f"{way} ({p_value_said(line.p_value)})"


def _correlation(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """R is negative, and as large as in the paper."""
    found = agent.correlation
    if found.r is None or agent.blind or found.low is None or found.high is None or found.n < 4 or abs(found.r) == 1:
        return NOT_MEASURED
    errors = [1 / math.sqrt(n - 3) for n in (found.n, CORRELATION_POINTS)]
    p_value = apart(math.atanh(found.r), math.atanh(CORRELATION), errors)
    said = minus(f"{found.r:.2f} [{found.low:.2f}, {found.high:.2f}] over {found.n} points")
    shown = pattern(found.p_value, -found.r)
    sign = {"shown": "r is negative", "opposite": "r is positive", "open": "no correlation was detected"}
    test = f"Fisher's z test; {sign[shown]}; neither value is evidence of harm by loops"
    return said, verdict_of(p_value, shown), test, p_value


def _left(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Most first loops are left before the trial ends."""
    found, chance = counted[0].persistence.left, counted[0].persistence.left_by_chance
    if not found.n or chance is None:
        return NOT_MEASURED
    said = f"{found.count} of {found.n} first loops were left before the trial ended, {100 * found.value:.0f} % "
    said += f"[{100 * found.low:.0f}, {100 * found.high:.0f}]; {100 * chance:.0f} % for random actions"
    shown: ClaimPattern = "shown" if found.low > 0.5 else "opposite" if found.high < 0.5 else "open"
    return said, borne_out(shown), "95 % interval above or below one half; trials with true reports", None


def _trapped(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """Actions in a loop leave it less often than by chance."""
    return _versus_chance(
        counted[0].persistence.escaped, "actions in a loop leave it", "leaving a loop, Student over trials", -1
    )


def _repeats(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    """After an unchanged observation blocked joints are tried again more often than by chance."""
    what = "actions after a blocked report repeat a joint that was just blocked"
    return _versus_chance(counted[0].persistence.repeated, what, "trying a blocked joint again, Student over trials", 1)


def _versus_chance(found: VersusChance, what: str, test: str, sign: int) -> ClaimFinding:
    """Actions of a kind against chance; the claim expects a difference of this sign."""
    share = found.share
    if not share.n or found.uniform is None or found.no_repeat is None or found.p_value is None:
        return NOT_MEASURED
    said = f"{share.count} of {share.n} {what}, {100 * share.value:.0f} % "
    said += f"[{100 * share.low:.0f}, {100 * share.high:.0f}]; "
    said += f"{100 * found.uniform:.0f} % for random actions, {100 * found.no_repeat:.0f} % without immediate repeats"
    shown = pattern(found.p_value, sign * found.direction)
    told = f"{sized(test)}; trials with true reports; any other preference also differs from chance"
    return said, borne_out(shown), told, found.p_value


LOOP_MEASURES: Mapping[str, ClaimMeasure] = {
    "loops": _loops,
    "loops-drop": _drop,
    "loops-rise": _rise,
    "onset": tested("looping", -1),
    "correlation": _correlation,
    "harm": tested("harm", -1),
    "loops-left": _left,
    "trapped": _trapped,
    "repeats": _repeats,
}
"""What measures a claim about loops."""
