"""What a report says of the attempt that came before it: its outcome, in words too, and the positions it implies."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from lockprobe.trial.record import Moment, Outcome, Task, Trial


def in_words(outcome: Outcome | bool | None, nothing: str = "nothing") -> str:
    """An outcome in words, given as such or as whether the joint moved; ``nothing`` where there is none.

    >>> in_words("moved"), in_words(False), in_words(None)
    ('moved', 'did not move', 'nothing')
    """
    return nothing if outcome is None else "moved" if outcome in (True, "moved") else "did not move"


def told_moved(now: Moment, before: Sequence[Moment], task: Task, *, really: bool) -> bool | None:
    """The reported outcome of the attempt, from outcome or positions; None if nothing is reported.

    Positions are compared with the last ones told or pictured. A picture that was not made from a report shows the
    truth.
    """
    told, shown = now.told, now.shown
    if told.outcome is not None:
        return told.outcome == "moved"
    if told.pictures and shown is None:
        return really
    if told.joint is None or shown is None:
        return None
    joint = task.joints.index(told.joint)
    for moment in reversed(before):
        if (last := moment.shown) is not None:
            return shown[joint] != last[joint]
    return None


def told_positions(moment: Moment) -> tuple[bool, ...] | None:
    """Positions for the record: the told ones, or those that false pictures show; None for true pictures."""
    if moment.told.positions is None and moment.shown == moment.was.positions:
        return None
    return moment.shown


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
