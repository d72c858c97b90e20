"""The numbers of the analysis as the typed rows of the results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from typing import Any, ClassVar, Protocol, TypeVar

from lockprobe.analysis.axis import Axis
from lockprobe.analysis.condition import ConditionSummary, Contrast
from lockprobe.analysis.detectors import share_flagged
from lockprobe.analysis.misinterpretation import Misinterpretations
from lockprobe.analysis.modalities import ModalityEffect, spoken
from lockprobe.analysis.pace import Pace
from lockprobe.analysis.persistence import VersusChance
from lockprobe.analysis.rationality import ACTIONS, JUDGED
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.audit.rates import false_positives
from lockprobe.prose.hypothesis_tests import asked, note_said, unit_said, why_missing
from lockprobe.record import Trial
from lockprobe.report import details
from lockprobe.report.claims import ClaimRow
from lockprobe.report.described import filled
from lockprobe.report.schema import ConditionResult

__all__ = [
    "claim_row",
    "condition_row",
    "contrast_row",
    "course_row",
    "detector_row",
    "fit_row",
    "judged",
    "modality_row",
    "pace_row",
    "rationality_rows",
    "test_rows",
]

_SAME = "the same at every flip rate"


def condition_row(condition: ConditionSummary, label: str, *, blind: bool = False) -> ConditionResult:
    """One agent under one condition; a blind agent plays the same trials under each."""
    success, loops, curve = condition.success, condition.behaviour.loops, condition.curve
    said, kept = condition.claims, condition.persistence
    return filled(
        ConditionResult,
        condition,
        condition.behaviour,
        curve,
        condition=condition.name,
        same_at_every_p=blind,
        trials=success.n,
        solved=success.count,
        success=success.value,
        success_low=success.low,
        success_high=success.high,
        looping=loops.count,
        loop_rate=loops.value,
        loop_rate_low=loops.low,
        loop_rate_high=loops.high,
        loop_rate_chance=condition.behaviour.chance_uniform,
        loop_rate_chance_no_repeat=condition.behaviour.chance_no_repeat,
        loop_rate_chance_markov=condition.behaviour.chance_markov,
        loop_rate_chance_permutation=condition.behaviour.chance_permutation,
        loop_rate_chance_error={null: level.error for null, level in condition.behaviour.chance.items()},
        loop_rate_by_symbol={str(symbol): share for symbol, share in condition.behaviour.by_symbol.items()},
        loops_left=details.AgainstChance(**asdict(kept.left), by_chance=kept.left_by_chance),
        loop_escape=_tested_against_chance(kept.escaped),
        repeated_after_blocked=_tested_against_chance(kept.repeated),
        policy_entropy=condition.behaviour.entropy,
        policy_entropy_steps=condition.behaviour.entropy_steps,
        **_claims(said),
        median_steps_all=curve.km_median,
        mean_steps_all=curve.restricted_mean_steps,
        steps_to_80=curve.steps_to(0.8),
        steps_to_80_interval=curve.steps_to_interval(0.8),
        errors=dict(condition.errors),
        broken=sum(condition.errors.values()),
        curve=details.CurveResult(steps=curve.steps, share=curve.share, low=curve.low, high=curve.high),
        steps=condition.steps,
        changed_steps=None if condition.changed is None else condition.changed.changed,
        changed={} if condition.changed is None else dict(condition.changed.by_intervention),
        against_rules=None if condition.rules is None else condition.rules.against,
        repetitions=[details.RepetitionResult(**asdict(point)) for point in condition.points],
        distinct_sequences=condition.distinct_sequences,
        label=label,
    )


def _tested_against_chance(kind: VersusChance) -> details.TestedAgainstChance:
    return details.TestedAgainstChance(
        **asdict(kind.share),
        by_chance=kind.uniform,
        by_chance_no_repeat=kind.no_repeat,
        p_value=kind.p_value,
    )


def _claims(said: Misinterpretations) -> dict[str, Any]:
    """The fields on what an agent said of its actions."""
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
        "misread": said.misinterpreted,
        "said_moved_told_blocked": said.moved_for_blocked,
        "said_blocked_told_moved": said.blocked_for_moved,
        "said_moved_of_misread": said.hallucinated,
        "false_report": said.falsely_told,
        "false_report_of_all_steps": said.false_reports,
        "false_belief": said.false_belief,
        "false_reports_believed": details.CountOf(count=said.believed, n=said.falsely_told.count),
        "false_reports_undone": said.undone,
        "claim_kinds": said.counts,
    }


class _Noted(Protocol):
    """A result with a short code for why it is missing, in a dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def note(self) -> str: ...


_N = TypeVar("_N", bound=_Noted)


def _worded(result: _N, axis: Axis) -> _N:
    """The result with its note in words."""
    return replace(result, note=why_missing(result.note, axis))


def fit_row(agent: AgentSummary) -> details.FitResult:
    """What runs over p for one agent: the paper's fits, the binomial ones, the peak, the onset of loops."""
    found, first = agent.inference, agent.inference.onset.primary
    return filled(
        details.FitResult,
        agent,
        success=_worded(agent.success_fit, agent.axis),
        loop_rate=_worded(agent.loop_fit, agent.axis),
        binomial=_worded(found.orders, agent.axis),
        two_lines=_worded(found.lines, agent.axis),
        lind_mehlum=_worded(found.bend, agent.axis),
        peak=_worded(agent.peak, agent.axis),
        difference_from_lowest=_worded(found.difference, agent.axis),
        steps_to_solve=found.speed,
        loop_onset=found.onset,
        loop_onset_two_lines=_worded(found.onset_lines, agent.axis),
        looped_by_step_12=details.LoopedByStep(lowest=first.lowest.by_step(12), higher=first.higher.by_step(12))
        if first
        else None,
        after_a_loop=_worded(found.hazard, agent.axis),
        after_a_loop_by_step_10=_worded(found.landmark, agent.axis),
        looped_against_solved=found.whole,
        broken=details.BrokenByCondition(
            at=[details.BrokenAt(p=p, **asdict(share)) for p, share in found.broken.at],
            p_value=found.broken.p_value,
            differ=found.broken.differ,
        )
        if found.broken
        else None,
        label=agent.name,
    )


def test_rows(agent: AgentSummary) -> list[details.TestRow]:
    """Every test of one agent, with the false-positive rates that the audit measured."""
    rows = []
    for test in agent.inference.tests:
        rates = false_positives(test.name)
        rows.append(
            filled(
                details.TestRow,
                test,
                agent,
                asks=asked(test.question, agent.axis),
                unit=unit_said(test, agent.axis),
                note=note_said(test, agent.axis),
                false_positives_low=rates[0].rate if rates else None,
                false_positives_high=rates[1].rate if rates else None,
                false_positives_worst=rates[1].world if rates else None,
                label=agent.name,
            )
        )
    return rows


def rationality_rows(
    condition: ConditionSummary, label: str, *, blind: bool = False
) -> list[details.RationalityResult]:
    """The actions of one condition before each ideal observer."""
    return [
        filled(
            details.RationalityResult,
            found,
            condition,
            condition=condition.name,
            p=_flip_rate(condition),
            same_at_every_p=blind,
            label=label,
        )
        for found in condition.rationality
    ]


def _flip_rate(condition: ConditionSummary) -> float | None:
    """The flip rate, or None under other interventions."""
    return None if math.isnan(condition.p) else condition.p


def judged(summary: StudySummary) -> details.JudgedResult:
    """How many trials were judged at most, what was left out and why, and whether the prior fits the box.

    It does not if reports that were all true were impossible under it.
    """
    conditions = summary.conditions
    found = [c.rationality for c in conditions if c.rationality]
    told_true = [observer for c in conditions if c.p == 0 for observer in c.rationality]
    return details.JudgedResult(
        trials=JUDGED,
        actions=ACTIONS,
        left_out_beyond_that=sum(observers[0].not_judged for observers in found),
        left_out_for_want_of_a_prior=sum(c.success.n for c in conditions if not c.rationality),
        prior_contradicted=any(observer.restarts > 0 for observer in told_true),
    )


def course_row(agent: AgentSummary) -> details.CourseResult | None:
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
    return details.CourseResult(
        agent=agent.agent,
        modality=agent.modality,
        **asdict(found) | {"kind": _SAME if agent.blind else found.kind},
        loops_first=loops[0],
        loops_least=min(loops),
        loops_last=loops[-1],
        looping=_SAME if agent.blind else onset,
        label=agent.name,
    )


def contrast_row(agent: AgentSummary, contrast: Contrast) -> details.ContrastResult:
    """The lowest p against the p whose success differs from it most clearly, in one sample of trials."""
    found, pairs = contrast.difference, contrast.difference.pairs
    return filled(
        details.ContrastResult,
        agent,
        contrast,
        found,
        baseline_p=contrast.baseline.p,
        other_p=contrast.other.p,
        all_trials=contrast.whole,
        baseline_solved=found.first.count,
        baseline_trials=found.first.n,
        other_solved=found.second.count,
        other_trials=found.second.n,
        difference=found.value,
        difference_low=found.low,
        difference_high=found.high,
        pairs=pairs.n if pairs else None,
        only_baseline=pairs.only_first if pairs else None,
        only_other=pairs.only_second if pairs else None,
        mcnemar=pairs.p_value if pairs else None,
        exchange_p_value=found.exchange,
        if_broken_unsolved=found.if_unsolved,
        if_broken_solved=found.if_solved,
        label=agent.name,
    )


def pace_row(compared: Pace, names: Mapping[tuple[str, str], str]) -> details.PaceResult:
    """Which of two agents, or of two modalities of one agent, is faster."""
    return details.PaceResult(
        **asdict(compared),
        first_label=names[compared.first],
        second_label=names[compared.second],
    )


def modality_row(effect: ModalityEffect) -> details.ModalityResult:
    """What the modality does to one agent."""
    return filled(details.ModalityResult, effect, spoken=[spoken(one) for one in effect.modalities])


def claim_row(row: ClaimRow) -> details.ClaimResult:
    """One claim of the paper against one agent."""
    return filled(details.ClaimResult, row, row.claim, paper=row.claim.value)


def detector_row(condition: ConditionSummary, trials: Iterable[Trial], label: str) -> details.DetectorResult:
    """The share of one condition's trials that each loop detector flags."""
    return filled(
        details.DetectorResult,
        condition,
        condition=condition.name,
        p=_flip_rate(condition),
        trials=condition.success.n,
        flagged=share_flagged([trial for trial in trials if trial.cell == condition.key]),
        label=label,
    )
