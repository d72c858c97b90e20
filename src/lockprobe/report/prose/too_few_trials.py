"""Sentences on the agents of an unfinished study: how many trials they have, and whether these are too few."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.formatting import listed

Finished = Mapping[str, tuple[int, int]]
"""Agent -> its finished trials, and those that are planned."""


def too_few_said(agents: Finished, *, others: bool = False) -> str:
    """That agents have too few trials; empty without such an agent.

    Args:
        agents: These agents.
        others: Whether there is an answer for others of those that the study is about.

    >>> too_few_said({"a": (4, 24), "b": (0, 24)})
    'Too few trials for an answer: a has finished 4 of 24 trials and b none of 24.'
    """
    begin = "Still to come" if others else "Too few trials for an answer"
    return f"{begin}: {finished_said(agents)}" if agents else ""


def finished_said(agents: Finished) -> str:
    """How many trials agents have finished; empty without an agent.

    >>> finished_said({"a": (8, 24)})
    'a has finished 8 of 24 trials.'
    """
    said = [
        f"{agent}{' has finished' * first} {done or 'none'} of {planned}{' trials' * first}"
        for first, (agent, (done, planned)) in zip([True] + [False] * len(agents), agents.items(), strict=False)
    ]
    return f"{listed(said, named=3)}." if said else ""


def of_baselines(answer: str) -> str:
    """An answer that is about baselines alone; empty where there is none."""
    return f"Baselines: {answer}" if answer else ""
