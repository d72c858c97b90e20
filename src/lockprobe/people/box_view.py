"""The scene of a box, made of the situation that every agent gets and of the layout of the panel.

Nothing here knows the truth: positions and outcomes are the reported ones, joints have their labels.
"""

from __future__ import annotations

import base64
from typing import Literal

from lockprobe.people.experiment import Experiment
from lockprobe.people.scenes import Box, BoxJoint, BoxPanel, PastStep
from lockprobe.pictures.picture import Picture
from lockprobe.plan import Names, Plan
from lockprobe.record import Percept, Situation, Task
from lockprobe.studies.modality import is_pictured

__all__ = ["View", "box_to_show", "is_asked", "panel_to_show", "view_of_modality"]

View = Literal["text", "panel", "pictures"]


def view_of_modality(modality: str, view: Literal["text", "panel"]) -> View:
    """The view of a modality: pictures where it has them, else ``view``."""
    return "pictures" if is_pictured(modality) else view


def box_to_show(plan: Plan, situation: Situation, *, experiment: Experiment, number: int, of: int) -> Box:
    """The scene of a step: box ``number`` of ``of``, from 1 and without the practice, which is 0."""
    return Box(
        practice=number == 0,
        number=number,
        of=of,
        step=len(situation.past) + 1,
        budget=situation.task.budget,
        ask=is_asked(situation),
        panel=panel_to_show(plan, situation, experiment.view),
        history=_history(situation) if experiment.history else (),
        history_open=experiment.history_open,
        device=experiment.device,
    )


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did."""
    return situation.task.assessment and bool(situation.past)


def panel_to_show(plan: Plan, situation: Situation, view: Literal["text", "panel"]) -> BoxPanel:
    """What the agent's channel shows now."""
    task, percept = situation.task, situation.percept
    shown = view_of_modality(plan.modality, view)
    kinds = [plan.box.joints[i].kind for i in Names(plan).order]
    handles = _handles(percept) if shown == "pictures" else {}
    joints = tuple(
        BoxJoint(
            label=label,
            target=label == task.target,
            kind=kinds[i] if shown == "panel" else None,
            place=task.places[i] if shown == "panel" else None,
            position=None if percept.positions is None else (1 if percept.positions[i] else 0),
            handle=handles.get(i),
        )
        for i, label in enumerate(task.joints)
    )
    return BoxPanel(
        view=shown,
        joints=joints,
        told=_told(percept),
        last=percept.joint,
        outcome=percept.outcome,
        pictures=tuple(_url(picture) for picture in percept.pictures if picture.shown),
    )


def _history(situation: Situation) -> tuple[PastStep, ...]:
    after = [*(turn.percept for turn in situation.past[1:]), situation.percept]
    return tuple(
        PastStep(
            step=number,
            joint=turn.decision.joint,
            told=_told(percept),
            outcome=percept.outcome,
            ones=_ones(situation.task, percept),
        )
        for number, (turn, percept) in enumerate(zip(situation.past, after, strict=False), 1)
    )


def _ones(task: Task, percept: Percept) -> tuple[str, ...] | None:
    if percept.positions is None:
        return None
    return tuple(label for label, position in zip(task.joints, percept.positions, strict=True) if position)


def _told(percept: Percept) -> str:
    return "" if percept.pictures else percept.text


def _url(picture: Picture) -> str:
    return "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")


def _handles(percept: Percept) -> dict[int, tuple[tuple[float, float], tuple[float, float]]]:
    """Where handles lie, as shares of the pictures; a place in pixels counts from the middle of the first pixel."""
    width, height = _size(percept.pictures[0])

    def share(place: tuple[float, float]) -> tuple[float, float]:
        return round((place[0] + 0.5) / width, 5), round((place[1] + 0.5) / height, 5)

    return {i: (share(zero), share(one)) for i, (zero, one) in enumerate(percept.handles)}


def _size(picture: Picture) -> tuple[int, int]:
    """Width and height, as a PNG file's first chunk has them."""
    return int.from_bytes(picture.png[16:20], "big"), int.from_bytes(picture.png[20:24], "big")
