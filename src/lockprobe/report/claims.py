"""The paper's claims beside what a study measured: whether the two are compatible, and which test says so."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.inference.verdict import Question, TestResult
from lockprobe.analysis.proportions import Proportion, difference, ratio
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.options import spec_name
from lockprobe.report.cells import minus
from lockprobe.report.compared import NOT_MEASURED, Found, Verdict, same_share, same_step, verdict_of
from lockprobe.report.modality_claims import MODALITY_MEASURES
from lockprobe.report.paper import (
    CLAIMS,
    CORRELATION,
    CORRELATION_POINTS,
    LOOPS_AT_0,
    LOOPS_AT_40,
    REFERENCE,
    SOLVED_AT_0,
    SOLVED_AT_40,
    TABLE1,
    MisreadRate,
    PaperClaim,
)

__all__ = ["ClaimRow", "claim_rows"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimRow:
    """One claim against one agent.

    Attributes:
        agent: Agent spec; empty if no agent of the study speaks to the claim.
        here: What was measured, in words.
        verdict: Whether the two are compatible, or whether this study bears the claim out.
        test: What the verdict rests on.
        p_value: Of that test, where it has one.
    """

    claim: PaperClaim
    agent: str
    here: str
    verdict: Verdict
    test: str
    p_value: float | None


def claim_rows(summary: StudySummary) -> tuple[ClaimRow, ...]:
    """Every claim against every agent that speaks to it, claims in the order of the paper."""
    rows = []
    for claim in CLAIMS:
        over_modalities = MODALITY_MEASURES.get(claim.measure)
        measured = over_modalities(summary) if over_modalities else _by_agent(claim, summary)
        known = [(agent, found) for agent, found in measured if found[1] != "not measured"]
        rows += [
            ClaimRow(claim=claim, agent=agent, here=here, verdict=verdict, test=test, p_value=p_value)
            for agent, (here, verdict, test, p_value) in known or [("", NOT_MEASURED)]
        ]
    return tuple(rows)


def _by_agent(claim: PaperClaim, summary: StudySummary) -> list[tuple[str, Found]]:
    """What every agent that was shown the box as the claim has it says to it."""
    reference = claim.measure in ("reference", "reference-steps")
    agents = [a for a in summary.agents if a.agent.startswith("human-inspired")] if reference else summary.subjects
    return [(agent.name, _measure(claim, agent)) for agent in agents if spec_name(agent.modality) == claim.modality]


def _measure(claim: PaperClaim, agent: AgentSummary) -> Found:
    """What one agent says to one claim."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted or counted[0].p != 0:
        return NOT_MEASURED
    if claim.measure == "misinterpretation":
        return _misinterpretation(counted[0], TABLE1[claim.modality])
    return _MEASURES[claim.measure](agent, counted)


def _told_the_truth(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    return same_share(counted[0].success, SOLVED_AT_0)


def _reference(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    return same_share(counted[0].success, REFERENCE)


def _loops(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    found, verdict, test, p_value = same_share(counted[0].behaviour.loops, LOOPS_AT_0)
    chance = counted[0].behaviour
    if chance.chance_uniform is None or chance.chance_no_repeat is None:
        return found, verdict, test, p_value
    by_chance = f"by chance {100 * chance.chance_uniform:.0f} to {100 * chance.chance_no_repeat:.0f} %"
    return f"{found}; {by_chance}", verdict, test, p_value


def _reference_steps(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    return same_step(counted[0], 9)


def _misinterpretation(condition: ConditionSummary, paper: MisreadRate) -> Found:
    said = condition.claims
    if said.mean_rate is None or said.sd_rate is None:
        return NOT_MEASURED
    here = f"{100 * said.mean_rate:.1f} % ± {100 * said.sd_rate:.1f} %, {said.total} in all, in {said.affected} of "
    from scipy.stats import ttest_ind_from_stats

    found = ttest_ind_from_stats(paper.mean, paper.sd, 10, said.mean_rate, said.sd_rate, said.trials, equal_var=False)
    p_value = float(found.pvalue) if math.isfinite(found.pvalue) else None
    return f"{here}{said.trials} trials", verdict_of(p_value), "Welch, on the rates per trial", p_value


def _peak(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    candidates = {f"{candidate.p:g}": candidate.in_set for candidate in agent.peak.candidates}
    if agent.blind or len(candidates) < 2 or candidates.get("0.4") is None or agent.peak.best is None:
        return NOT_MEASURED
    among = ", ".join(p for p, inside in candidates.items() if inside)
    verdict: Verdict = "compatible" if candidates["0.4"] else "not compatible"
    return f"highest at {agent.peak.best:g}; could be {among}", verdict, "95 % set of the best, bootstrap", None


def _at_40(counted: list[ConditionSummary]) -> ConditionSummary | None:
    return next((condition for condition in counted if math.isclose(condition.p, 0.4)), None)


def _ratio(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    other = _at_40(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    first, second = counted[0].success, other.success
    found = ratio(first, second)
    (here, error), (paper, their_error) = _log_ratio(first, second), _log_ratio(SOLVED_AT_0, SOLVED_AT_40)
    p_value = _apart(here, paper, [error, their_error])
    said = f"{second.count}/{second.n} at 0.4 over {first.count}/{first.n} at 0"
    if found:
        said += f": {found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"
    return said, verdict_of(p_value), "z of the logarithms of the ratios, half a trial added to each count", p_value


def _log_ratio(first: Proportion, second: Proportion) -> tuple[float, float]:
    """The logarithm of a ratio of shares, second over first, and its standard error (Walter 1975)."""
    shares = [((share.count + 0.5), (share.n + 0.5)) for share in (second, first)]
    (a, n), (b, m) = shares
    return math.log(a / n) - math.log(b / m), math.sqrt(1 / a - 1 / n + 1 / b - 1 / m)


def _loops_drop(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    other = _at_40(counted)
    if other is None or agent.blind:
        return NOT_MEASURED
    first, second = counted[0].behaviour.loops, other.behaviour.loops
    found = difference(first, second)
    assert found is not None
    interval = f"{100 * found.value:+.0f} points [{100 * found.low:+.0f}, {100 * found.high:+.0f}]"
    errors = [math.hypot(_error(a), _error(b)) for a, b in ((first, second), (LOOPS_AT_0, LOOPS_AT_40))]
    p_value = _apart(found.value, LOOPS_AT_40.value - LOOPS_AT_0.value, errors)
    said = f"{first.count}/{first.n} to {second.count}/{second.n}, {interval}"
    return minus(said), verdict_of(p_value), "z of the two differences", p_value


def _error(share: Proportion) -> float:
    """Standard error of a share with two more trials of each kind (Agresti and Coull)."""
    smooth = (share.count + 2) / (share.n + 4)
    return math.sqrt(smooth * (1 - smooth) / (share.n + 4))


def _correlation(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
    found = agent.correlation
    if found.r is None or agent.blind or found.low is None or found.high is None or found.n < 4 or abs(found.r) == 1:
        return NOT_MEASURED
    errors = [1 / math.sqrt(n - 3) for n in (found.n, CORRELATION_POINTS)]
    p_value = _apart(math.atanh(found.r), math.atanh(CORRELATION), errors)
    said = minus(f"{found.r:.2f} [{found.low:.2f}, {found.high:.2f}] over {found.n} points")
    return said, verdict_of(p_value), "Fisher's z; neither figure is evidence that loops do harm", p_value


def _apart(here: float, paper: float, errors: list[float]) -> float:
    """Two-sided p-value of two independent estimates with these standard errors being of one truth."""
    return 2 * NormalDist().cdf(-abs(here - paper) / math.hypot(*errors))


def _tested(question: Question, expected: Callable[[TestResult], bool]) -> Callable[..., Found]:
    """The recommended test of a question: borne out if it rejects in the direction of the claim."""

    def measure(agent: AgentSummary, counted: list[ConditionSummary]) -> Found:
        (test,) = (t for t in agent.inference.tests if t.question == question and t.recommended)
        if test.p_value is None or agent.blind:
            return NOT_MEASURED
        said = "" if test.effect is None else minus(f"{test.effect:.2f} ({test.unit})")
        verdict: Verdict = "borne out" if test.rejects and expected(test) else "not borne out"
        return said, verdict, test.name, test.p_value

    return measure


def _less(test: TestResult) -> bool:
    return test.direction < 0


_MEASURES: dict[str, Callable[[AgentSummary, list[ConditionSummary]], Found]] = {
    "reference": _reference,
    "reference-steps": _reference_steps,
    "baseline": _told_the_truth,
    "peak": _peak,
    "ratio": _ratio,
    "effect": _tested("success", lambda test: (test.effect or 0) > 0),
    "shape": _tested("shape", lambda test: True),
    "loops": _loops,
    "loops-drop": _loops_drop,
    "onset": _tested("looping", _less),
    "correlation": _correlation,
    "harm": _tested("harm", _less),
}
