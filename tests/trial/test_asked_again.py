"""Replies that could not be used are counted where somebody was asked again, and nowhere else."""

from dataclasses import replace

from builders import make_trial

from lockprobe.trial.asked_again import asked_again
from lockprobe.trial.record import TrialError


def replied(agent, *replies, broken=()):
    """A trial with so many replies to each decision, and an error after so many."""
    trial = make_trial([0] * len(replies), agent=agent, budget=9, broken="reply" if broken else None)
    steps = [
        replace(step, decision=replace(step.decision, replies=("?",) * n))
        for step, n in zip(trial.steps, replies, strict=True)
    ]
    error = TrialError(boundary="reply", message="m", step=9, replies=("?",) * broken[0]) if broken else None
    return replace(trial, steps=tuple(steps), error=error)


def test_every_reply_but_the_last_was_asked_for_again():
    trials = [replied("llm:a", 1, 3, 1), replied("llm:a", 2, broken=(5,)), replied("llm:b", 1, 1), replied("random", 0)]
    assert asked_again(trials) == {"llm:a": (2 + 1 + 4, 5 + 2 + 5)}
    assert asked_again(replace(trial, called="Ours") for trial in trials) == {"Ours": (7, 14)}
    assert asked_again([replied("llm:b", 1, broken=(1,))]) == {}
