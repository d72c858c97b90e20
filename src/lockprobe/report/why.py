"""Why false reports change success: its rows of ``results.json`` and its tables."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.why import ArmEffect, Why
from lockprobe.formatting import NONE, bracketed, p_cell, share
from lockprobe.prose.why import arm_said, why_said
from lockprobe.report.examples import ToldTwice
from lockprobe.report.format import TextTable
from lockprobe.report.schema import ArmResult, EstimateResult, WhyResult

__all__ = ["arm_table", "estimate_table", "why_row"]


def why_row(found: Why, twice: ToldTwice | None) -> WhyResult:
    """The numbers of one agent as a row of ``results.json``.

    Args:
        found: Its numbers.
        twice: One of its trials under true and under false reports.
    """
    return WhyResult(
        agent=found.agent,
        modality=found.modality,
        p=found.p,
        verdict=found.verdict,
        said=why_said(found),
        arms=[_arm(one) for one in found.arms],
        change=_estimate(found.change),
        says=_estimate(found.says),
        disturbs=_estimate(found.disturbs),
        falsity=_maybe(found.falsity),
        disturbance=_maybe(found.disturbance),
        interaction=_maybe(found.interaction),
        margin=found.margin,
        equivalence=found.equivalence,
        needed=found.needed,
        twice=twice,
    )


def _arm(one: ArmEffect) -> ArmResult:
    return ArmResult(
        arm=one.arm,
        condition=one.condition,
        what=arm_said(one.arm),
        trials=one.success.n,
        solved=one.success.count,
        success=one.success.value,
        success_low=one.success.low,
        success_high=one.success.high,
        change=_maybe(one.change),
    )


def _maybe(one: BlockMean | None) -> EstimateResult | None:
    return None if one is None else _estimate(one)


def _estimate(one: BlockMean) -> EstimateResult:
    return EstimateResult(value=one.value, low=one.low, high=one.high, p_value=one.p_value, blocks=one.blocks)


def arm_table(rows: Sequence[WhyResult]) -> TextTable:
    """Success in every arm, and against true reports."""
    head = ["agent", "arm", "at the steps that are hit", "solved", "success", "against truth, points", "P"]
    return [head] + [
        [
            row.agent,
            one.arm,
            one.what,
            f"{one.solved}/{one.trials}",
            share(one.success, one.success_low, one.success_high),
            bracketed(one.change.value, one.change.low, one.change.high) if one.change else NONE,
            p_cell(one.change.p_value) if one.change else NONE,
        ]
        for row in rows
        for one in row.arms
    ]


def estimate_table(rows: Sequence[WhyResult]) -> TextTable:
    """The effect of lies and its parts."""
    head = ["agent", "estimand", "arms", "points", "P", "blocks"]
    named = (
        ("what lies do", "lie - truth", "change"),
        ("what they say (debunking)", "lie - retracted", "says"),
        ("that they disturb", "retracted - truth", "disturbs"),
        ("falsity", "half of (lie - truth) + (lie + remark - remark)", "falsity"),
        ("disturbance", "half of (remark - truth) + (lie + remark - lie)", "disturbance"),
        ("interaction", "(lie + remark - remark) - (lie - truth)", "interaction"),
    )
    return [head] + [
        [row.agent, name, arms, bracketed(one.value, one.low, one.high), p_cell(one.p_value), str(one.blocks)]
        for row in rows
        for name, arms, of in named
        if (one := getattr(row, of)) is not None
    ]
