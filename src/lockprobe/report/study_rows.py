"""Rows that the results of every study have: progress, trials left out, broken trials, facts, and the shipped audit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from lockprobe.agents.reply_text import TIDIED
from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.rules import together
from lockprobe.audit.rates import shipped
from lockprobe.prose.robot import not_judged, rules_said
from lockprobe.record import Decision, Fact, Trial
from lockprobe.report.details import (
    AuditedRate,
    AuditedSentence,
    AuditedSentences,
    AuditResult,
    BrokenTrials,
    LeftOutResult,
    TidiedReplies,
)
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.schema import StudyProgress
from lockprobe.studies.records import LeftOut

__all__ = [
    "agent_facts",
    "audit_result",
    "broken_rows",
    "left_out_row",
    "not_judged_of",
    "plant_facts",
    "rules_said_of",
    "study_progress",
    "tidied_rows",
]

_MANY = 8
"""Values of a fact beyond which they are counted."""


def study_progress(opened: OpenedStudy) -> StudyProgress:
    """How far the study has come, in places of the plan, those of people included."""
    planned, finished = opened.study.size, opened.finished
    return StudyProgress(planned=planned, finished=finished, partial=finished < planned)


def left_out_row(trials: Sequence[Trial], journal: LeftOut, not_asked_for: int) -> LeftOutResult:
    """What is on record and in no number, and what was played twice.

    Args:
        trials: Those that the settings ask for.
        journal: What the journal leaves out.
        not_asked_for: Trials that the settings do not ask for.
    """
    return LeftOutResult(
        errors=sum(trial.ending == "error" for trial in trials),
        replayed_on_request=sum(trial.replays > 0 for trial in trials),
        replaced_after_an_error=journal.replaced,
        repeated=journal.repeated,
        unfinished_lines=journal.unfinished_lines,
        not_asked_for=not_asked_for,
        foreign=journal.foreign,
    )


def agent_facts(trials: Iterable[Trial]) -> dict[str, dict[str, str]]:
    """What every agent was, as it says itself."""
    return _facts(chain.from_iterable(_told(trial) for trial in trials))


def plant_facts(trials: Iterable[Trial], settings: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """What the plant was, as it says itself."""
    return _facts((str(settings.get("plant")), _known(trial.plant)) for trial in trials)


def _facts(told: Iterable[tuple[str, Mapping[str, Fact]]]) -> dict[str, dict[str, str]]:
    """What every agent was, or the plant; where trials differ, all values are labelled, or how many there are."""
    found: dict[str, dict[str, dict[str, None]]] = {}
    for what, facts in told:
        for name, value in facts.items():
            found.setdefault(what, {}).setdefault(name, {})[str(value)] = None
    return {
        what: {
            name: "; ".join(values) if len(values) <= _MANY else f"{len(values)} different values"
            for name, values in facts.items()
        }
        for what, facts in found.items()
    }


def _told(trial: Trial) -> Iterator[tuple[str, Mapping[str, Fact]]]:
    """What the agent said it was, and which models answered in its place, as their provider names them."""
    yield trial.group, trial.facts
    for served in dict.fromkeys(step.decision.served for step in trial.steps):
        if served:
            yield trial.group, {"answered by": served}


def _known(facts: Mapping[str, Fact]) -> dict[str, Fact]:
    """Without what a plant does not have, as a renderer where nobody looks."""
    return {name: value for name, value in facts.items() if value is not None}


def rules_said_of(conditions: Iterable[ConditionSummary]) -> str:
    """How many attempts broke the rules of the box; empty if none did."""
    found = together(one.rules for one in conditions)
    return rules_said(found) if found else ""


def not_judged_of(conditions: Iterable[ConditionSummary]) -> str:
    """Why no agent is judged; empty if no attempt broke the rules of the box."""
    return not_judged(together(one.rules for one in conditions))


def broken_rows(trials: Sequence[Trial]) -> list[BrokenTrials]:
    """Broken trials by agent and boundary, with the first message, and whether they are owed again."""
    broken = [(trial, trial.error) for trial in trials if trial.error is not None]
    counts = Counter((trial.group, str(error.boundary)) for trial, error in broken)
    first = {(trial.group, str(error.boundary)): (error.message, trial.owed_again) for trial, error in reversed(broken)}
    return [
        BrokenTrials(agent=agent, boundary=boundary, trials=count, message=message, owed_again=owed_again)
        for (agent, boundary), count in sorted(counts.items())
        for message, owed_again in (first[agent, boundary],)
    ]


def tidied_rows(trials: Sequence[Trial]) -> list[TidiedReplies]:
    """The agents some of whose replies were tidied."""
    decisions: dict[str, list[Decision]] = {}
    for trial in trials:
        decisions.setdefault(trial.group, []).extend(step.decision for step in trial.steps)
    return [
        TidiedReplies(
            agent=agent,
            decisions=len(made),
            tidied=tidied,
            what=dict(Counter(TIDIED.get(what, what) for one in made for what in one.tidied).most_common()),  # type: ignore[call-overload]
        )
        for agent, made in decisions.items()
        if (tidied := sum(bool(one.tidied) for one in made))
    ]


def audit_result() -> AuditResult:
    """The shipped audit."""
    audit = shipped()
    many = audit["many_agents"]
    return AuditResult(
        seed=audit["seed"],
        worlds=audit["worlds"],
        rates=[AuditedRate(**rate) for rate in audit["rates"]],
        many_agents=AuditedSentences(worlds=many["worlds"], rates=[AuditedSentence(**rate) for rate in many["rates"]]),
    )
