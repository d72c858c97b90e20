"""The numbers of a study as plain rows, as ``results.json`` holds them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from lockprobe.analysis.condition import ConditionSummary, Contrast
from lockprobe.analysis.detectors import share_flagged
from lockprobe.analysis.modalities import ModalityEffect, spoken
from lockprobe.analysis.pace import Pace
from lockprobe.analysis.rationality import ACTIONS, JUDGED
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.audit.shipped_rates import false_positives
from lockprobe.prose.hypothesis_tests import asked, note_said, unit_said, why_missing
from lockprobe.record import Trial
from lockprobe.report.claims import ClaimRow

__all__ = [
    "claim_row",
    "condition_row",
    "contrast_row",
    "course_row",
    "detector_rows",
    "fit_row",
    "judged",
    "labelled",
    "modality_row",
    "pace_row",
    "rationality_rows",
    "test_rows",
]

Row = dict[str, Any]


def condition_row(condition: ConditionSummary, *, blind: bool = False) -> Row:
    """One agent under one condition; a blind agent plays the same trials under each."""
    success, loops, curve = condition.success, condition.behaviour.loops, condition.curve
    return {
        "key": condition.key,
        "agent": condition.agent,
        "condition": condition.name,
        "modality": condition.modality,
        "p": condition.p,
        "same_at_every_p": blind,
        "trials": success.n,
        "solved": success.count,
        "success": success.value,
        "success_low": success.low,
        "success_high": success.high,
        "looping": loops.count,
        "loop_rate": loops.value,
        "loop_rate_low": loops.low,
        "loop_rate_high": loops.high,
        "loop_rate_chance": condition.behaviour.chance_uniform,
        "loop_rate_chance_no_repeat": condition.behaviour.chance_no_repeat,
        "loop_rate_chance_markov": condition.behaviour.chance_markov,
        "loop_rate_chance_permutation": condition.behaviour.chance_permutation,
        "loop_rate_chance_error": {null: level.error for null, level in condition.behaviour.chance.items()},
        "loop_rate_by_symbol": dict(condition.behaviour.by_symbol),
        "coverage": condition.behaviour.coverage,
        "redundant_share": condition.behaviour.redundant_share,
        "loops_left": asdict(condition.persistence.left) | {"by_chance": condition.persistence.left_by_chance},
        "repeated_after_blocked": asdict(condition.persistence.repeated)
        | {"by_chance": condition.persistence.repeated_by_chance, "p_value": condition.persistence.repeated_p_value},
        "policy_entropy": condition.behaviour.entropy,
        "policy_entropy_steps": condition.behaviour.entropy_steps,
        **_said(condition),
        "median_steps": curve.median_steps,
        "median_steps_all": curve.km_median,
        "mean_steps": curve.mean_steps,
        "mean_steps_all": curve.restricted_mean_steps,
        "steps_to_80": curve.steps_to(0.8),
        "steps_to_80_interval": curve.steps_to_interval(0.8),
        "area": asdict(curve.area) if curve.area else None,
        "relative": asdict(condition.relative) if condition.relative else None,
        "errors": dict(condition.errors),
        "broken": sum(condition.errors.values()),
        "curve": {"steps": curve.steps, "share": curve.share, "low": curve.low, "high": curve.high},
        "repetitions": [asdict(point) for point in condition.points],
    }


def _said(condition: ConditionSummary) -> Row:
    """What the agent said had happened, held against what it was told and against the truth."""
    said = condition.claims
    return {
        "misinterpretations": said.total if said.trials or not said.not_asked else None,
        "misinterpretation_rate": said.mean_rate,
        "misinterpretation_rate_sd": said.sd_rate,
        "misinterpretation_rate_pooled": said.pooled.value,
        "misinterpretation_trials": said.trials,
        "misinterpretation_trials_affected": said.affected,
        "misinterpretation_trials_not_asked": said.not_asked,
        "claims": said.pooled.n,
        "claims_against_truth": said.against_truth.count,
        "misread": asdict(said.misinterpreted),
        "said_moved_told_blocked": asdict(said.moved_for_blocked),
        "said_blocked_told_moved": asdict(said.blocked_for_moved),
        "said_moved_of_misread": asdict(said.hallucinated),
        "false_report": asdict(said.falsely_told),
        "false_report_of_all_steps": asdict(said.false_reports),
        "false_belief": asdict(said.false_belief),
        "false_reports_believed": {"count": said.believed, "n": said.falsely_told.count},
        "false_reports_undone": said.undone,
        "claim_kinds": [asdict(kind) for kind in said.counts],
    }


def fit_row(agent: AgentSummary) -> Row:
    """What runs over p for one agent: the paper's fits, the binomial ones, the peak, the onset of loops."""
    found, first = agent.inference, agent.inference.onset.primary

    def worded(one: Any) -> Row:
        return asdict(one) | {"note": why_missing(one.note, agent.axis)}

    return {
        "agent": agent.agent,
        "modality": agent.modality,
        "reference": agent.reference,
        "blind": agent.blind,
        "success": worded(agent.success_fit),
        "loop_rate": worded(agent.loop_fit),
        "correlation": asdict(agent.correlation),
        "binomial": worded(found.orders),
        "two_lines": worded(found.lines),
        "lind_mehlum": worded(found.bend),
        "peak": worded(agent.peak),
        "difference_from_lowest": worded(found.difference),
        "steps_to_solve": asdict(found.speed),
        "loop_onset": asdict(found.onset),
        "looped_by_step_12": {"lowest": first.lowest.by_step(12), "higher": first.higher.by_step(12)}
        if first
        else None,
        "after_a_loop": worded(found.hazard),
        "after_a_loop_by_step_10": worded(found.landmark),
        "looped_against_solved": asdict(found.whole),
        "broken": {
            "at": [{"p": p} | asdict(share) for p, share in found.broken.at],
            "p_value": found.broken.p_value,
            "differ": found.broken.differ,
        }
        if found.broken
        else None,
    }


def test_rows(agent: AgentSummary) -> list[Row]:
    """Every test of one agent, with the false-positive rates that the audit measured."""
    rows = []
    for test in agent.inference.tests:
        rates = false_positives(test.name)
        rows.append(
            {
                "agent": agent.agent,
                "modality": agent.modality,
                "asks": asked(test.question, agent.axis),
                "name": test.name,
                "question": test.question,
                "recommended": test.recommended,
                "p_value": test.p_value,
                "effect": test.effect,
                "low": test.low,
                "high": test.high,
                "baseline": test.baseline,
                "unit": unit_said(test, agent.axis),
                "direction": test.direction,
                "holds": test.holds,
                "note": note_said(test, agent.axis),
                "rejects": test.rejects,
                "false_positives_low": rates[0].rate if rates else None,
                "false_positives_high": rates[1].rate if rates else None,
                "false_positives_worst": rates[1].world if rates else None,
            }
        )
    return rows


def rationality_rows(condition: ConditionSummary, *, blind: bool = False) -> list[Row]:
    """The actions of one condition before each ideal observer."""
    names = {"key": condition.key, "agent": condition.agent, "modality": condition.modality, "p": condition.p}
    return [names | {"same_at_every_p": blind} | asdict(found) for found in condition.rationality]


def judged(summary: StudySummary) -> Row:
    """How many trials were judged at most, what was left out and why, and whether the prior fits the box.

    It does not if reports that were all true were impossible under it.
    """
    conditions = summary.conditions
    found = [c.rationality for c in conditions if c.rationality]
    told_true = [observer for c in conditions if c.p == 0 for observer in c.rationality]
    return {
        "trials": JUDGED,
        "actions": ACTIONS,
        "left_out_beyond_that": sum(observers[0].not_judged for observers in found),
        "left_out_for_want_of_a_prior": sum(c.success.n for c in conditions if not c.rationality),
        "prior_contradicted": any(observer.restarts > 0 for observer in told_true),
    }


def course_row(agent: AgentSummary) -> Row | None:
    """How success goes over p for one agent, and its loop rate; None without trials."""
    found = agent.inference.course
    if found is None:
        return None
    loops = [condition.behaviour.loops.value for condition in agent.conditions if condition.success.n]
    looping = next(test for test in agent.inference.tests if test.question == "looping" and test.recommended)
    if looping.p_value is None:
        onset = "not tested"
    else:
        onset = ("later" if looping.direction < 0 else "sooner") if looping.rejects else "no change detectable"
    return {
        "agent": agent.agent,
        "modality": agent.modality,
        **asdict(found),
        "kind": "the same at every flip rate" if agent.blind else found.kind,
        "loops_first": loops[0],
        "loops_least": min(loops),
        "loops_last": loops[-1],
        "looping": "the same at every flip rate" if agent.blind else onset,
    }


def contrast_row(agent: AgentSummary, contrast: Contrast) -> Row:
    """The lowest p against the p whose success differs from it most clearly, in one sample of trials."""
    found, pairs = contrast.difference, contrast.difference.pairs
    return {
        "agent": agent.agent,
        "modality": agent.modality,
        "baseline_p": contrast.baseline.p,
        "other_p": contrast.other.p,
        "choices": contrast.choices,
        "farthest": contrast.farthest,
        "all_trials": contrast.whole,
        "baseline_solved": found.first.count,
        "baseline_trials": found.first.n,
        "other_solved": found.second.count,
        "other_trials": found.second.n,
        "difference": found.value,
        "difference_low": found.low,
        "difference_high": found.high,
        "pairs": pairs.n if pairs else None,
        "only_baseline": pairs.only_first if pairs else None,
        "only_other": pairs.only_second if pairs else None,
        "mcnemar": pairs.p_value if pairs else None,
        "fisher": contrast.fisher,
        "exchange_p_value": found.exchange,
        "p_value": found.p_value,
        "if_broken_unsolved": asdict(found.if_unsolved) if found.if_unsolved else None,
        "if_broken_solved": asdict(found.if_solved) if found.if_solved else None,
        "detectable": contrast.detectable,
    }


def pace_row(compared: Pace, names: Mapping[tuple[str, str], str]) -> Row:
    """Which of two agents, or of two ways of showing the box to one, is faster."""
    return {
        **asdict(compared),
        "first_label": names[compared.first],
        "second_label": names[compared.second],
    }


def modality_row(effect: ModalityEffect) -> Row:
    """What the way of showing the box does to one agent."""
    return {
        **asdict(effect),
        "detectable": effect.detectable,
        "differs_in_fidelity": effect.differs_in_fidelity,
        "spoken": [spoken(one) for one in effect.modalities],
    }


def labelled(rows: Iterable[Row], names: Mapping[tuple[str, str], str]) -> list[Row]:
    """Rows of an agent and a modality with the name under which pages show them."""
    return [{**row, "label": names[row["agent"], row["modality"]]} for row in rows]


def claim_row(row: ClaimRow) -> Row:
    """One claim of the paper against one agent."""
    return {
        "place": row.claim.place,
        "quote": row.claim.quote,
        "quoted": row.claim.quoted,
        "paper": row.claim.value,
        "recomputed": row.claim.recomputed,
        "agent": row.agent,
        "here": row.here,
        "verdict": row.verdict,
        "test": row.test,
        "p_value": row.p_value,
    }


def detector_rows(conditions: list[tuple[ConditionSummary, list[Trial]]]) -> list[Row]:
    """The share of trials that each loop detector flags, condition by condition."""
    return [
        {"key": condition.key, "agent": condition.agent, "modality": condition.modality, "p": condition.p}
        | {"trials": condition.success.n}
        | {"flagged": share_flagged(trials)}
        for condition, trials in conditions
    ]
