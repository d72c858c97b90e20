"""The paper's claims about modalities (Sec. 3.1) beside what a study of several measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from lockprobe.analysis.modalities import spoken
from lockprobe.analysis.proportions import ALPHA
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.options import spec_name
from lockprobe.report.compared import NOT_MEASURED, Found, Verdict, same_share, same_step
from lockprobe.report.paper import MODALITY, STEPS_TO_80

__all__ = ["MODALITY_MEASURES"]

Measured = list[tuple[str, Found]]
"""What every agent that speaks to a claim says, by its name."""


def _compared(summary: StudySummary) -> Iterator[AgentSummary]:
    """The agents that the study is about, once for each of several ways in which they were shown the box."""
    several = {effect.agent for effect in summary.modalities}
    for agent in summary.subjects:
        if agent.agent in several and agent.conditions[0].success.n and agent.conditions[0].p == 0:
            yield agent


def _final(summary: StudySummary) -> Measured:
    return [(agent.name, same_share(agent.conditions[0].success, MODALITY)) for agent in _compared(summary)]


def _steps(summary: StudySummary) -> Measured:
    return [
        (agent.name, same_step(agent.conditions[0], STEPS_TO_80[spec_name(agent.modality)]))
        for agent in _compared(summary)
        if spec_name(agent.modality) in STEPS_TO_80
    ]


def _order(summary: StudySummary) -> Measured:
    """Is the box solved sooner the lower the fidelity is?"""
    agents = {agent.agent for agent in _compared(summary)}
    found: Measured = []
    for effect in summary.modalities:
        if effect.agent not in agents or effect.p_value is None:
            found.append((effect.agent, NOT_MEASURED))
            continue
        curves = {agent.modality: agent.conditions[0].curve for agent in summary.agents if agent.agent == effect.agent}
        steps = [(spoken(modality), curves[modality].restricted_mean_steps) for modality in effect.modalities]
        here = "mean steps " + ", ".join(f"{mean:.1f} with {words}" for words, mean in steps if mean is not None)
        verdict: Verdict = "borne out" if effect.detectable and effect.direction < 0 else "not borne out"
        found.append((effect.agent, (here, verdict, "log-rank for a trend over fidelity", effect.p_value)))
    return found


def _reference_faster(summary: StudySummary) -> Measured:
    """Is the human-inspired strategy, told the state, faster than an agent shown the box in each way?"""
    compared = {(agent.agent, agent.modality): agent.name for agent in _compared(summary)}
    found: Measured = []
    for pace in summary.paces:
        first, second = pace.first, pace.second
        reference, other = (first, second) if _is_reference(first) else (second, first)
        if not _is_reference(reference) or other not in compared or pace.p_value is None or not pace.hazard_ratio:
            continue
        ratio = pace.hazard_ratio if reference == second else 1 / pace.hazard_ratio
        here = f"hazard of solving, {reference[0]} over this agent: {ratio:.2f}"
        verdict: Verdict = "borne out" if ratio > 1 and pace.p_value < ALPHA else "not borne out"
        found.append((compared[other], (here, verdict, "log-rank, shared luck kept together", pace.p_value)))
    return found


def _is_reference(both: tuple[str, str]) -> bool:
    return spec_name(both[0]).partition(":")[0] == "human-inspired" and both[1] == "symbolic"


MODALITY_MEASURES: Mapping[str, Callable[[StudySummary], Measured]] = {
    "modalities": _final,
    "modality-order": _order,
    "modality-steps": _steps,
    "reference-faster": _reference_faster,
}
"""What measures a claim over modalities."""
