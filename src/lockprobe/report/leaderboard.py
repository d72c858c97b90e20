"""Agents side by side as rows of ``results.json``: who stands where, every two compared, what it cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from lockprobe.analysis.agent_comparison.leaderboard_row import Standing, condition_regret
from lockprobe.analysis.agent_comparison.pair import Comparison
from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.record import Trial
from lockprobe.report.costs import Money, money

__all__ = ["comparison_rows", "interaction_rows", "leaderboard_rows"]

Row = dict[str, Any]
Names = Mapping[tuple[str, str], str]


def leaderboard_rows(summary: StudySummary, trials: Sequence[Trial]) -> list[Row]:
    """Every agent over all p, the highest success first, and the same by p."""
    agents = {(agent.agent, agent.modality): agent for agent in summary.agents}
    return [
        _over_all(row, agents[row.agent, row.modality], trials)
        for row in summary.standings
    ]  # fmt: skip


def _over_all(row: Standing, agent: AgentSummary, trials: Sequence[Trial]) -> Row:
    own = [trial for trial in trials if (trial.group, trial.modality) == (row.agent, row.modality)]
    spent = money(own)
    return {
        "agent": row.agent,
        "modality": row.modality,
        "label": agent.name,
        "reference": agent.reference,
        "same_at_every_p": agent.blind,
        "rank_low": row.ranks[0] if row.ranks else None,
        "rank_high": row.ranks[1] if row.ranks else None,
        "trials": row.success.n,
        "broken": sum(sum(condition.errors.values()) for condition in agent.conditions),
        "success": asdict(row.success),
        "steps_to_80": row.steps_to_80,
        "regret": asdict(row.regret) if row.regret else None,
        "loop_rate": asdict(row.loops),
        "loop_rate_chance": row.chance,
        "loop_rate_chance_no_repeat": row.chance_no_repeat,
        "loops_above_chance": _less(row.loops.value, row.chance),
        "loops_above_chance_no_repeat": _less(row.loops.value, row.chance_no_repeat),
        "misread": asdict(row.misread),
        "not_asked": row.not_asked,
        "money": _money_row(spent),
        "prices": asdict(spent.price) if spent.price else None,
        "served": dict(spent.served),
        "by_p": [_at(condition, [trial for trial in own if trial.p == condition.p]) for condition in agent.conditions],
    }


def _at(condition: ConditionSummary, trials: Sequence[Trial]) -> Row:
    """One condition of the same agent."""
    found, regret = condition.behaviour, condition_regret(condition)
    return {
        "p": condition.p,
        "trials": condition.success.n,
        "success": asdict(condition.success),
        "steps_to_80": condition.curve.steps_to(0.8),
        "regret": asdict(regret) if regret else None,
        "loop_rate": asdict(found.loops),
        "loop_rate_chance": found.chance_uniform,
        "loops_above_chance": _less(found.loops.value, found.chance_uniform),
        "misread": asdict(condition.claims.misinterpreted),
        "not_asked": condition.claims.not_asked,
        "money": _money_row(money(trials)),
    }


def _money_row(spent: Money) -> Row:
    counted = spent.usage
    return {
        "calls": spent.calls,
        "uncounted_calls": spent.uncounted,
        "input_tokens": counted.input_tokens if counted else None,
        "cached_share": counted.cached_tokens / counted.input_tokens if counted and counted.input_tokens else None,
        "output_tokens": counted.output_tokens if counted else None,
        "reasoning_tokens": counted.reasoning_tokens if counted else None,
        "dollars": spent.dollars,
        "dollars_per_solved": spent.per_solved,
    }


def _less(value: float, chance: float | None) -> float | None:
    return None if chance is None else value - chance


def comparison_rows(compared: Sequence[Comparison], names: Names) -> list[Row]:
    """Every two agents on the same boxes; differences are the second less the first."""
    return [
        {
            **_pair(one, names),
            "among": one.among,
            "first_success": one.first_share,
            "second_success": one.second_share,
            "success": asdict(one.success) | {"p_adjusted": one.success_adjusted},
            "steps": asdict(one.steps) | {"p_adjusted": one.steps_adjusted},
            "verdict": one.verdict,
            "steps_verdict": one.steps_verdict,
            "same_at_every_p": one.copies,
            "finished_by_one_only": one.alone,
            "bounded": one.bounded,
            "by_p": [
                {"p": at.p, "success": asdict(at.success) | {"p_adjusted": at.p_adjusted}, "steps": asdict(at.steps)}
                for at in one.at
            ],
        }
        for one in compared
    ]


def interaction_rows(compared: Sequence[Comparison], names: Names) -> list[Row]:
    """Whether false reports change both agents of a pair alike."""
    return list(_interactions(compared, names))


def _interactions(compared: Sequence[Comparison], names: Names) -> Iterator[Row]:
    for one in compared:
        if one.interaction:
            yield {**_pair(one, names), **asdict(one.interaction)}


def _pair(one: Comparison, names: Names) -> Row:
    return {
        "first": one.first[0],
        "second": one.second[0],
        "first_modality": one.first[1],
        "second_modality": one.second[1],
        "first_label": names[one.first],
        "second_label": names[one.second],
    }
