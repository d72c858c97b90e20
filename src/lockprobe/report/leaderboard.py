"""Agents side by side as rows of ``results.json``: who stands where, every two compared, what it cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from lockprobe.agents.llm.model_facts import Price
from lockprobe.analysis.agent_comparison.interaction import InteractionAt
from lockprobe.analysis.agent_comparison.leaderboard_row import Regret, Standing, condition_regret
from lockprobe.analysis.agent_comparison.pair import AgentComparison
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.clustered import ClusteredProportion
from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.proportions import Paired, Proportion
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.record import Trial
from lockprobe.report.costs import Money, Prices, money
from lockprobe.report.described import filled

__all__ = [
    "Adjusted",
    "AdjustedPairs",
    "ComparisonByDose",
    "ComparisonResult",
    "InteractionResult",
    "LeaderboardByDose",
    "LeaderboardResult",
    "MoneyResult",
    "PairResult",
    "comparison_rows",
    "interaction_rows",
    "leaderboard_rows",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class MoneyResult:
    """What the trials of an agent cost; None where it is not known."""

    calls: int | None
    uncounted_calls: int
    input_tokens: int | None
    cached_share: float | None
    output_tokens: int | None
    reasoning_tokens: int | None
    dollars: float | None
    dollars_per_solved: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaderboardByDose:
    """One agent at one flip rate."""

    p: float
    trials: int
    success: Proportion
    steps_to_80: int | None
    regret: Regret | None
    loop_rate: Proportion
    loop_rate_chance: float | None
    loops_above_chance: float | None
    misread: ClusteredProportion
    not_asked: int
    money: MoneyResult


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaderboardResult:
    """One agent over all flip rates, with its rank."""

    agent: str
    modality: str
    label: str
    reference: bool
    same_at_every_p: bool
    rank_low: int | None
    rank_high: int | None
    trials: int
    broken: int
    success: ClusteredProportion
    steps_to_80: int | None
    regret: Regret | None
    loop_rate: ClusteredProportion
    loop_rate_chance: float | None
    loop_rate_chance_no_repeat: float | None
    loops_above_chance: float | None
    loops_above_chance_no_repeat: float | None
    misread: ClusteredProportion
    not_asked: int
    money: MoneyResult
    prices: Price | None
    served: Mapping[str, int]
    by_p: Sequence[LeaderboardByDose]


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusted(BlockMean):
    """A mean difference with its p-value corrected for the number of pairs."""

    p_adjusted: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AdjustedPairs(Paired):
    """Pairs of trials with a p-value corrected for the number of pairs of agents and flip rates."""

    p_adjusted: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonByDose:
    """Two agents at one flip rate."""

    p: float
    success: AdjustedPairs
    steps: BlockMean


@dataclass(frozen=True, slots=True, kw_only=True)
class PairResult:
    """Two agents that are compared."""

    first: str
    second: str
    first_modality: str
    second_modality: str
    first_label: str
    second_label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonResult(PairResult):
    """Two agents on the same boxes; differences are the second less the first."""

    among: str
    first_success: float
    second_success: float
    success: Adjusted
    steps: Adjusted
    verdict: int
    steps_verdict: int
    same_at_every_p: bool
    finished_by_one_only: int
    bounded: bool
    by_p: Sequence[ComparisonByDose]


@dataclass(frozen=True, slots=True, kw_only=True)
class InteractionResult(PairResult):
    """Whether false reports change both agents of a pair alike."""

    lowest: float
    at: Sequence[InteractionAt]
    mean: BlockMean
    p_value: float
    p_adjusted: float | None


AgentNames = Mapping[tuple[str, str], str]


def leaderboard_rows(
    summary: StudySummary, trials: Sequence[Trial], prices: Prices | None = None
) -> list[LeaderboardResult]:
    """Every agent over all p, the highest success first, and the same by p; ``prices`` as in :func:`money`."""
    agents = {(agent.agent, agent.modality): agent for agent in summary.agents}
    return [_over_all(row, agents[row.agent, row.modality], trials, prices) for row in summary.standings]


def _over_all(row: Standing, agent: AgentSummary, trials: Sequence[Trial], prices: Prices | None) -> LeaderboardResult:
    own = [trial for trial in trials if (trial.group, trial.modality) == (row.agent, row.modality)]
    spent = money(own, prices)
    return filled(
        LeaderboardResult,
        row,
        agent,
        label=agent.name,
        same_at_every_p=agent.blind,
        rank_low=row.ranks[0] if row.ranks else None,
        rank_high=row.ranks[1] if row.ranks else None,
        trials=row.success.n,
        broken=sum(sum(condition.errors.values()) for condition in agent.conditions),
        loop_rate=row.loops,
        loop_rate_chance=row.chance,
        loop_rate_chance_no_repeat=row.chance_no_repeat,
        loops_above_chance=_less(row.loops.value, row.chance),
        loops_above_chance_no_repeat=_less(row.loops.value, row.chance_no_repeat),
        money=_money_row(spent),
        prices=spent.price,
        served=dict(spent.served),
        by_p=[
            _at(condition, [trial for trial in own if trial.p == condition.p], prices) for condition in agent.conditions
        ],
    )


def _at(condition: ConditionSummary, trials: Sequence[Trial], prices: Prices | None) -> LeaderboardByDose:
    """One condition of the same agent."""
    found = condition.behaviour
    return LeaderboardByDose(
        p=condition.p,
        trials=condition.success.n,
        success=condition.success,
        steps_to_80=condition.curve.steps_to(0.8),
        regret=condition_regret(condition),
        loop_rate=found.loops,
        loop_rate_chance=found.chance_uniform,
        loops_above_chance=_less(found.loops.value, found.chance_uniform),
        misread=condition.claims.misinterpreted,
        not_asked=condition.claims.not_asked,
        money=_money_row(money(trials, prices)),
    )


def _money_row(spent: Money) -> MoneyResult:
    counted = spent.usage
    return MoneyResult(
        calls=spent.calls,
        uncounted_calls=spent.uncounted,
        input_tokens=counted.input_tokens if counted else None,
        cached_share=counted.cached_tokens / counted.input_tokens if counted and counted.input_tokens else None,
        output_tokens=counted.output_tokens if counted else None,
        reasoning_tokens=counted.reasoning_tokens if counted else None,
        dollars=spent.dollars,
        dollars_per_solved=spent.per_solved,
    )


def _less(value: float, chance: float | None) -> float | None:
    return None if chance is None else value - chance


def comparison_rows(compared: Sequence[AgentComparison], names: AgentNames) -> list[ComparisonResult]:
    """Every two agents on the same boxes; differences are the second less the first."""
    return [
        filled(
            ComparisonResult,
            one,
            **_pair(one, names),
            first_success=one.first_share,
            second_success=one.second_share,
            success=Adjusted(**asdict(one.success), p_adjusted=one.success_adjusted),
            steps=Adjusted(**asdict(one.steps), p_adjusted=one.steps_adjusted),
            same_at_every_p=one.copies,
            finished_by_one_only=one.alone,
            by_p=[
                ComparisonByDose(
                    p=at.p,
                    success=AdjustedPairs(**asdict(at.success), p_adjusted=at.p_adjusted),
                    steps=at.steps,
                )
                for at in one.at
            ],
        )
        for one in compared
    ]


def interaction_rows(compared: Sequence[AgentComparison], names: AgentNames) -> list[InteractionResult]:
    """Whether false reports change both agents of a pair alike."""
    return [filled(InteractionResult, one.interaction, **_pair(one, names)) for one in compared if one.interaction]


def _pair(one: AgentComparison, names: AgentNames) -> dict[str, str]:
    return {
        "first": one.first[0],
        "second": one.second[0],
        "first_modality": one.first[1],
        "second_modality": one.second[1],
        "first_label": names[one.first],
        "second_label": names[one.second],
    }
