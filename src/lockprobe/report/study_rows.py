"""Rows that the results of every study have: trials left out, broken trials, facts, and the shipped audit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from lockprobe.audit.rates import shipped
from lockprobe.record import Fact, Trial
from lockprobe.report.details import (
    AuditedRate,
    AuditedSentence,
    AuditedSentences,
    AuditResult,
    BrokenTrials,
    LeftOutResult,
)
from lockprobe.studies.records import LeftOut

__all__ = ["agent_facts", "audit_result", "broken_rows", "left_out_row", "plant_facts"]

_MANY = 8
"""Values of a fact beyond which they are counted."""


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
