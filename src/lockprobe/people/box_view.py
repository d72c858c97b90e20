"""The scene of a box, made of the situation that every agent gets and of the layout of the panel.

Nothing here knows the truth: positions and outcomes are the reported ones, joints have their labels.
"""

from __future__ import annotations

import base64
from typing import Literal

from lockprobe.interventions.words import TextChannel
from lockprobe.people.experiment import Experiment
from lockprobe.people.scenes import Box, BoxJoint, BoxPanel, PastStep
from lockprobe.studies.modality import is_pictured, shown
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Percept, Situation, Task

View = Literal["panel", "pictures"]


def view_of_modality(modality: str) -> View:
    """The view of a modality: pictures where it has them, else the drawn panel."""
    return "pictures" if is_pictured(modality) else "panel"


def box_to_show(plan: Plan, situation: Situation, *, experiment: Experiment, number: int, of: int) -> Box:
    """The scene of a step: box ``number`` of ``of``, from 1 and without the practice, which is 0."""
    return Box(
        practice=number == 0,
        number=number,
        of=of,
        step=len(situation.past) + 1,
        budget=situation.task.budget,
        ask=is_asked(situation),
        panel=panel_to_show(plan, situation),
        remark=situation.briefing.remark,
        warning=situation.briefing.warning,
        history=_history(plan, situation) if experiment.history else (),
        history_open=experiment.history_open,
        device=experiment.device,
    )


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did; models cannot either where no action is named."""
    return situation.task.assessment and situation.percept.joint is not None


def panel_to_show(plan: Plan, situation: Situation) -> BoxPanel:
    """What the agent's channel shows now."""
    task, percept = situation.task, situation.percept
    seen = view_of_modality(plan.modality)
    kinds = [plan.box.joints[i].kind for i in Names(plan).order]
    handles = _handles(percept) if seen == "pictures" else {}
    joints = tuple(
        BoxJoint(
            label=label,
            target=label == task.target,
            kind=kinds[i] if seen == "panel" else None,
            place=task.places[i] if seen == "panel" else None,
            position=None if percept.positions is None else (1 if percept.positions[i] else 0),
            handle=handles.get(i),
        )
        for i, label in enumerate(task.joints)
    )
    return BoxPanel(
        view=seen,
        joints=joints,
        told=_told(percept),
        verbatim=_is_verbatim(plan, task, percept, first=not situation.past),
        last=percept.joint,
        outcome=percept.outcome,
        pictures=tuple(_url(picture) for picture in percept.pictures if picture.shown),
    )


def _history(plan: Plan, situation: Situation) -> tuple[PastStep, ...]:
    after = [
        *((turn.percept, turn.remark) for turn in situation.past[1:]),
        (situation.percept, situation.briefing.remark),
    ]
    return tuple(
        PastStep(
            step=number,
            joint=turn.decision.joint,
            about=percept.joint,
            told=_told(percept),
            verbatim=_is_verbatim(plan, situation.task, percept),
            outcome=percept.outcome,
            ones=_ones(situation.task, percept),
            remark=remark,
        )
        for number, (turn, (percept, remark)) in enumerate(zip(situation.past, after, strict=False), 1)
    )


def _ones(task: Task, percept: Percept) -> tuple[str, ...] | None:
    if percept.positions is None:
        return None
    return tuple(label for label, position in zip(task.joints, percept.positions, strict=True) if position)


def _told(percept: Percept) -> str:
    return "" if percept.pictures else percept.text


def _is_verbatim(plan: Plan, task: Task, percept: Percept, *, first: bool = False) -> bool:
    """Whether the words of a report say something else than its facts do in the sentences of its modality.

    So it is where an intervention acts on words, and where a report corrects another one.
    """
    channel = shown(plan.modality)
    return isinstance(channel, TextChannel) and percept.text != channel.written(percept, task, first=first)


def _url(picture: Picture) -> str:
    return "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")


def _handles(percept: Percept) -> dict[int, tuple[tuple[float, float], tuple[float, float]]]:
    """Where handles lie, as shares of the pictures; a place in pixels counts from the middle of the first pixel."""
    if not percept.pictures:
        return {}
    header = percept.pictures[0].png[16:24]  # of the first chunk of a PNG file
    width, height = int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")

    def share(place: tuple[float, float]) -> tuple[float, float]:
        return round((place[0] + 0.5) / width, 5), round((place[1] + 0.5) / height, 5)

    return {i: (share(zero), share(one)) for i, (zero, one) in enumerate(percept.handles)}
