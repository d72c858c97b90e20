"""What reports say of attempts: an outcome in words, and which reports were false."""

from __future__ import annotations

from itertools import pairwise

from lockprobe.trial.record import Outcome, Trial


def in_words(outcome: Outcome | bool | None, nothing: str = "nothing") -> str:
    """An outcome in words, given as such or as whether the joint moved; ``nothing`` where there is none.

    >>> in_words("moved"), in_words(False), in_words(None)
    ('moved', 'did not move', 'nothing')
    """
    return nothing if outcome is None else "moved" if outcome in (True, "moved") else "did not move"


def false_reports(trial: Trial) -> list[bool]:
    """Whether each report after which the trial went on was inverted.

    What an agent infers from two reports of positions is inverted if outcomes are. Where positions are inverted
    (``flip?inverts=position``), the earlier report may be false too; then the report itself counts: it is false if it
    shows the attempted joint in the wrong position.
    """
    if not (trial.states_only and any(channel.get("inverts") == "position" for channel in trial.channels)):
        return [step.told_falsely for step in trial.steps[:-1]]
    places = [trial.joints.index(step.joint) for step in trial.steps]
    return [
        step.told_state is not None and step.told_state[place] != after.state[place]
        for place, (step, after) in zip(places, pairwise(trial.steps), strict=False)
    ]
