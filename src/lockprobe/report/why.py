"""Why false reports change success: its rows of ``results.json`` and its tables."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from lockprobe.analysis.why import ArmEffect, Why
from lockprobe.formatting import NONE, bracketed, p_cell, share
from lockprobe.prose.why import arm_said, why_said
from lockprobe.report.described import Change, Counted, DescribedResult, Share, filled
from lockprobe.report.examples import ToldTwice
from lockprobe.report.format import TextTable

__all__ = ["ArmResult", "EstimateResult", "WhyResult", "arm_table", "estimate_table", "why_row"]


class EstimateResult(DescribedResult):
    """A difference in success over blocks of equal luck."""

    value: Change | None = Field(description="The difference, [-1, 1]; an interaction can reach 2.")
    low: Change | None = Field(description="Lower end of its 95 % interval, corrected for agents alone.")
    high: Change | None = Field(description="Upper end.")
    p_value: Share = Field(description="Exchange of signs of whole blocks, corrected for agents.")
    blocks: Counted = Field(description="Blocks that have a trial in every arm compared.")


class ArmResult(DescribedResult):
    """One arm of a study of why false reports change success."""

    arm: str = Field(
        description="truth, lie, retracted, confirmed, remark, lie + remark, withheld, tremble, nudge or on request."
    )
    condition: str = Field(description="Name of the condition.")
    what: str
    trials: Counted = Field(description="Trials that ended as solved or out of budget.")
    solved: Counted = Field(description="Of these, solved.")
    success: Share = Field(description="Share solved, [0, 1].")
    success_low: Share = Field(description="Lower end of its 95 % Wilson interval.")
    success_high: Share = Field(description="Upper end.")
    change: EstimateResult | None = Field(description="Against truth; its P value is also corrected for arms (Holm).")


class WhyResult(DescribedResult):
    """Why false reports change the success of one agent."""

    agent: str = Field(description="Agent spec.")
    modality: str = Field(description="How the box was shown.")
    p: float = Field(description="The rate of the intervention.")
    verdict: str = Field(description="says, disturbs, both, unexplained, no change or not detectable.")
    said: list[str] = Field(description="The verdict and its numbers, in sentences.")
    arms: list[ArmResult] = Field(description="Success in every arm.")
    change: EstimateResult = Field(description="Lie minus truth.")
    says: EstimateResult = Field(description="Lie minus retracted lie: the effect of the content.")
    disturbs: EstimateResult = Field(description="Retracted lie minus truth: the effect of the disturbance.")
    falsity: EstimateResult | None = Field(description="False minus true reports, mean without and with a remark.")
    disturbance: EstimateResult | None = Field(
        description="With minus without a remark, mean for true and false reports."
    )
    interaction: EstimateResult | None = Field(description="The effect of a lie with a remark minus that without.")
    contingent: EstimateResult | None = Field(description="Lies in loops minus equally many lies at random steps.")
    margin: float = Field(description="Smaller changes count as no change.")
    equivalence: Share = Field(description="P value of two one-sided tests of that change or more, corrected alike.")
    needed: Counted = Field(description="Blocks that detect a change of the margin with a power of 80 %.")
    agents: Counted = Field(description="Agents that are judged together.")
    twice: ToldTwice | None


def why_row(found: Why, twice: ToldTwice | None) -> WhyResult:
    """The numbers of one agent as a row of ``results.json``.

    Args:
        found: Its numbers.
        twice: One of its trials under true and under false reports.
    """
    return filled(WhyResult, found, said=why_said(found), arms=[_arm(one) for one in found.arms], twice=twice)


def _arm(one: ArmEffect) -> ArmResult:
    return filled(
        ArmResult,
        one,
        what=arm_said(one.arm),
        trials=one.success.n,
        solved=one.success.count,
        success=one.success.value,
        success_low=one.success.low,
        success_high=one.success.high,
    )


def arm_table(rows: Sequence[WhyResult]) -> TextTable:
    """Success in every arm, and its difference from true reports."""
    head = ["agent", "arm", "at the selected steps", "solved", "success", "difference from truth, points", "P"]
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
    """The effect of false reports and its parts."""
    head = ["agent", "estimand", "arms", "estimate, points", "P", "blocks"]
    named = (
        ("total effect", "lie - truth", "change"),
        ("content (debunking effect)", "lie - retracted", "says"),
        ("disturbance", "retracted - truth", "disturbs"),
        ("falsity, mean effect", "half of (lie - truth) + (lie + remark - remark)", "falsity"),
        ("remark, mean effect", "half of (remark - truth) + (lie + remark - lie)", "disturbance"),
        ("falsity by remark, interaction", "(lie + remark - remark) - (lie - truth)", "interaction"),
        ("timing in loops", "lie in loops - self-yoked", "contingent"),
    )
    return [head] + [
        [row.agent, name, arms, bracketed(one.value, one.low, one.high), p_cell(one.p_value), str(one.blocks)]
        for row in rows
        for name, arms, of in named
        if (one := getattr(row, of)) is not None
    ]
