"""Replies that could not be used, so that the agent was asked again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from lockprobe.trial.record import Trial


def asked_again(trials: Iterable[Trial]) -> dict[str, tuple[int, int]]:
    """Agent -> replies after which it was asked again, and all its replies on record; agents without any are left out.

    After the last reply of a decision, and after one that ended a trial, nobody was asked again.
    """
    again, replies = Counter[str](), Counter[str]()
    for trial in trials:
        replied = [step.decision.replies for step in trial.steps]
        if trial.error is not None:  # those that led to no decision
            replied.append(trial.error.replies)
        if of_each := [len(one) for one in replied if one]:
            again[trial.group] += sum(of_each) - len(of_each)
            replies[trial.group] += sum(of_each)
    return {agent: (number, replies[agent]) for agent, number in again.items() if number}
