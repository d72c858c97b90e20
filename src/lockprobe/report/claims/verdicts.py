"""The paper's claims, compared with what a study measured: the verdict on each as a whole, and which test says so."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.spec import spec_kind, spec_name
from lockprobe.report.claims.agent_claims import AGENT_MEASURES, misread_measure
from lockprobe.report.claims.claim_tests import NOT_MEASURED, ClaimFinding
from lockprobe.report.claims.modality_claims import MODALITY_MEASURES, agents_shown
from lockprobe.report.claims.paper import CLAIMS, PaperClaim
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.summary import StudySummary


def claim_rows(summary: StudySummary) -> list[tuple[PaperClaim, str, ClaimFinding]]:
    """Every claim against every agent that speaks to it, claims in the order of the paper.

    Returns:
        The claim, the name of the agent, and what was found; a claim to which none speaks has an empty name.
    """
    rows = []
    for claim in CLAIMS:
        known = [(agent, found) for agent, found in _measured(claim, summary) if found[1] != "not measured"]
        rows += [(claim, agent, found) for agent, found in known or [("", NOT_MEASURED)]]
    return rows


def _measured(claim: PaperClaim, summary: StudySummary) -> Iterator[tuple[str, ClaimFinding]]:
    """What every agent that was shown the box as the claim has it says to it."""
    if claim.measure in ("reading", "mechanism"):
        return  # one flip axis has one reading, and no pictures
    if measure := MODALITY_MEASURES.get(claim.measure):
        yield from ((effect.agent, measure(summary, effect, shown)) for effect, shown in agents_shown(summary))
        return
    reference = claim.measure in ("reference", "reference-steps")
    for agent in summary.agents if reference else summary.subjects:
        if spec_name(agent.modality) == claim.modality and (not reference or spec_kind(agent.spec) == "human-inspired"):
            yield agent.name, _of_agent(claim, agent)


def _of_agent(claim: PaperClaim, agent: AgentSummary) -> ClaimFinding:
    counted = [condition for condition in agent.conditions if condition.success.n]
    if not counted or counted[0].dose != 0:
        return NOT_MEASURED
    if measure := AGENT_MEASURES.get(claim.measure):
        return measure(agent, counted)
    return misread_measure(claim.measure, counted[0].claims, claim.modality)
