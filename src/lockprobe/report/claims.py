"""The paper's claims, compared with what a study measured: the verdict on each as a whole, and which test says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.published import REFERENCE, REFERENCE_STEPS, TABLE1
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.report.claim_tests import NOT_MEASURED, ClaimFinding, ClaimMeasure, ClaimVerdict, same_share, same_step
from lockprobe.report.loop_claims import LOOP_MEASURES
from lockprobe.report.misread_claims import hallucinated, misread
from lockprobe.report.modality_claims import MODALITY_MEASURES
from lockprobe.report.noise_claims import NOISE_MEASURES
from lockprobe.report.paper import CLAIMS, PaperClaim
from lockprobe.spec import spec_kind, spec_name

__all__ = ["ClaimRow", "claim_rows"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimRow:
    """One claim against one agent.

    Attributes:
        agent: Its name or spec; empty if no agent of the study speaks to the claim.
        here: What was measured, in words.
        verdict: On the claim as a whole, not on one of its figures.
        test: What the verdict rests on.
        p_value: Of that test, where it has one.
    """

    claim: PaperClaim
    agent: str
    here: str
    verdict: ClaimVerdict
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


def _by_agent(claim: PaperClaim, summary: StudySummary) -> list[tuple[str, ClaimFinding]]:
    """What every agent that was shown the box as the claim has it says to it."""
    reference = claim.measure in ("reference", "reference-steps")
    agents = [a for a in summary.agents if spec_kind(a.spec) == "human-inspired"] if reference else summary.subjects
    return [(agent.name, _measure(claim, agent)) for agent in agents if spec_name(agent.modality) == claim.modality]


def _measure(claim: PaperClaim, agent: AgentSummary) -> ClaimFinding:
    """What one agent says to one claim."""
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted or counted[0].p != 0:
        return NOT_MEASURED
    if claim.measure in _MISREAD:
        return _MISREAD[claim.measure](counted[0].claims, TABLE1[claim.modality])
    return _MEASURES[claim.measure](agent, counted)


def _reference(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    return same_share(counted[0].success, REFERENCE)


def _reference_steps(agent: AgentSummary, counted: list[ConditionSummary]) -> ClaimFinding:
    return same_step(counted[0], REFERENCE_STEPS)


_MISREAD = {"misinterpretation": misread, "hallucination": hallucinated}

_MEASURES: Mapping[str, ClaimMeasure] = {
    "reference": _reference,
    "reference-steps": _reference_steps,
    **NOISE_MEASURES,
    **LOOP_MEASURES,
}
