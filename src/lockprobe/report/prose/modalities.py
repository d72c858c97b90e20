"""Sentences on modalities: their effect on how soon an agent solves the box."""

from __future__ import annotations

from lockprobe.foundation.formatting import corrected
from lockprobe.foundation.formatting import p_value as p_said
from lockprobe.report.prose.subject import Subject
from lockprobe.report.prose.success import of_trials
from lockprobe.statistics.conditions.modalities import ModalityEffect, spoken
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.summary import StudySummary

__all__ = ["modality_finding"]


def modality_finding(effect: ModalityEffect, summary: StudySummary) -> str:
    """Success and steps of one agent in each modality, and whether a difference was detected."""
    found = {agent.modality: agent.conditions[0] for agent in summary.agents if agent.agent == effect.agent}
    shown = "; ".join(
        f"{of_trials(one.success)} with {spoken(modality)}, 80 % {f'by step {step}' if step else 'not reached'}"
        for modality in effect.modalities
        for one in [found[modality]]
        for step in [one.curve.steps_to(0.8)]
    )
    who = Subject.of(effect.agent)
    return f"{who.first} solved {shown}. {_how_soon(effect, who)}"


def _how_soon(effect: ModalityEffect, who: Subject) -> str:
    """The trend over fidelity; the comparison of all modalities where they have only one fidelity."""
    p_value = effect.p_value if effect.differs_in_fidelity else effect.p_all
    if p_value is None:
        return "There are too few trials to compare how soon."
    solves = who.form("it solves", "they solve")
    together = f"clustered by block, {p_said(p_value)}{corrected((effect.agents, 'agents'))}"
    if not effect.differs_in_fidelity:
        what, how = "the modality", f"log-rank test over all modalities, {together}"
        if p_value < ALPHA:
            return f"How soon {solves} the box differs with {what} ({how})."
    else:
        what, how = "fidelity", f"log-rank test for a trend over fidelity, {together}"
        if effect.detectable:
            sooner = "sooner" if effect.direction > 0 else "later or more rarely"
            return f"The higher the fidelity, the {sooner} {solves} the box ({how})."
    return (
        f"No effect of {what} on how soon {solves} the box was detected ({how}); "
        "this does not show that there is no effect."
    )
