"""The replies of a hosted model in a trial that cannot be played again, held against its decisions one by one.

Without the plant nobody knows the requests. But the words of every reply are on record twice, and a reply names a joint
and a claim, whatever it was asked.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from lockprobe.agents.prompt import claims
from lockprobe.agents.reply_text import object_in
from lockprobe.agents.reply_values import values_in
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Decision, Percept, Situation, Task, Trial


def other_replies(trial: Trial, own: Sequence[Call], parent: Sequence[Call] = ()) -> str:
    """Where decisions and errors of a trial are not its replies in the log of calls; empty if nowhere.

    Args:
        trial: The trial.
        own: The replies that it has in the log of calls.
        parent: If it is a fork, those of its trial: its steps before its own first reply are from there.
    """
    first = min((call.step for call in own), default=len(trial.steps) + 1)
    logged, recorded = defaultdict[int, list[str]](list), defaultdict[int, list[str]](list)
    for call in (*(call for call in parent if call.step < first), *own):
        logged[call.step].append(call.reply or "")
    for step in trial.steps:
        recorded[step.step] += step.decision.replies
    if trial.error is not None:
        recorded[trial.error.step] += trial.error.replies
    last = len(trial.steps) if trial.owed_again or parent else max((*logged, *recorded), default=0)
    for number in range(1, last + 1):
        if logged[number] != recorded[number]:
            return f"step {number}, replies"
    return next(filter(None, (_another_decision(trial, step.decision, step.step) for step in trial.steps)), "")


def _another_decision(trial: Trial, decision: Decision, number: int) -> str:
    """What a reply names otherwise than its decision; empty if nothing, or if only its request says what it means."""
    if not decision.replies:
        return f"step {number}, a decision without a reply"
    asked = ["joint", *(["last_action"] if decision.claimed is not None else [])]
    before = trial.labels[trial.joints.index(trial.steps[number - 2].joint)] if number > 1 else None
    task = Task(joints=trial.listing, target=trial.target, budget=trial.budget)
    now = Situation(task=task, past=(), percept=Percept(joint=before))
    try:
        said = values_in(object_in(decision.replies[-1], asked).fields, asked, claims(now), now)
    except ReplyFault:
        return ""
    different = [name for name in ("joint", "claimed") if getattr(said, name) != getattr(decision, name)]
    return f"step {number}, decision ({', '.join(different)})" if different else ""
