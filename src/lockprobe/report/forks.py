"""The effect of one report, from forks of recorded trials: its rows of ``results.json`` and its table."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from lockprobe.analysis.branch import BranchEffect
from lockprobe.formatting import NONE, bracketed, p_cell, percent
from lockprobe.prose.branch import value_said
from lockprobe.report.described import Counted, DescribedResult, FiniteNumber, Share
from lockprobe.report.format import TextTable

__all__ = ["ForkResult", "fork_rows", "fork_table"]


class ForkResult(DescribedResult):
    """The effect of an arm at one place of one agent's trials, compared with a true report there."""

    agent: str = Field(description="Agent spec.")
    condition: str = Field(description="The condition of the trials that were forked, as keys of records say it.")
    where: str = Field(description="The step whose report was changed, or onset, first-lie or before-onset.")
    arm: str = Field(description="truth, lie, retracted, confirmed, remark, withheld, tremble, random or force=JOINT.")
    truthful: bool = Field(description="Whether all later reports are true.")
    outcome: str = Field(description="solved, steps, leaves, repeats or choice.")
    after_truth: FiniteNumber = Field(description="Mean of the outcome after a true report.")
    change: FiniteNumber = Field(description="Its change; of choice the total variation distance.")
    low: FiniteNumber = Field(description="Lower end of the 95 % interval over trials, corrected for agents.")
    high: FiniteNumber = Field(description="Upper end.")
    p_value: Share = Field(description="Exchange of signs of trials; of solved also corrected per agent (Holm).")
    agents: Counted = Field(description="Agents that are judged together.")
    trials: Counted = Field(description="Trials that were forked there.")
    forks: Counted = Field(description="Pairs of forks.")


def fork_rows(effects: Sequence[BranchEffect]) -> list[ForkResult]:
    """The effects as rows of ``results.json``."""
    return [
        ForkResult(
            agent=one.agent,
            condition=one.condition,
            where=one.where,
            arm=one.arm,
            truthful=one.truthful,
            outcome=one.outcome,
            after_truth=one.after_truth,
            change=one.change.value,
            low=one.change.low,
            high=one.change.high,
            p_value=one.change.p_value,
            agents=one.agents,
            trials=one.change.blocks,
            forks=one.forks,
        )
        for one in effects
    ]


_OTHERS = {"steps": "steps", "leaves": "leaves loop", "repeats": "repeats", "choice": "next choice"}
"""Outcomes besides success -> the heads of their columns."""


def fork_table(rows: Sequence[ForkResult]) -> TextTable:
    """One row for each agent, condition, place and arm."""
    head = ["agent", "condition", "forked at", "arm", "later reports", "solved after truth", "change, points", "P"]
    cells: dict[tuple[str, ...], dict[str, ForkResult]] = {}
    for row in rows:
        later = "true" if row.truthful else "as in the condition"
        cells.setdefault((row.agent, row.condition, row.where, row.arm, later), {})[row.outcome] = row
    table = [[*head, *_OTHERS.values(), "trials"]]
    for names, found in cells.items():
        if solved := found.get("solved"):
            size = bracketed(solved.change, solved.low, solved.high)
            others = [_value(found[outcome]) if outcome in found else NONE for outcome in _OTHERS]
            told = percent(solved.after_truth)
            table.append([*names, told, size, p_cell(solved.p_value), *others, str(solved.trials)])
    return table


def _value(row: ForkResult) -> str:
    return NONE if row.change is None else value_said(row.outcome, row.change)
