"""The scene of a box, made of the situation that every agent gets and of the layout of the panel.

Nothing here knows the truth: positions and outcomes are the reported ones, joints have their labels. The interlock, how
often reports are false, the condition and the number of the trial are nowhere in a scene.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any, Literal

from lockprobe.interventions.words import TextChannel
from lockprobe.people.experiment import Experiment
from lockprobe.people.texts import filled
from lockprobe.studies.modality import is_pictured, shown
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Percept, Situation, Task

Scene = dict[str, Any]
"""What the page shows, as it is sent; ``kind`` says which scene it is."""

Sentences = Mapping[str, str]
"""The ``page`` of the texts."""


def view_of_modality(modality: str) -> Literal["panel", "pictures"]:
    """The view of a modality: pictures where it has them, else the drawn panel."""
    return "pictures" if is_pictured(modality) else "panel"


def box_to_show(
    plan: Plan, situation: Situation, words: Sentences, *, experiment: Experiment, number: int, of: int
) -> Scene:
    """The scene of a step: box ``number`` of ``of``, from 1 and without the practice, which is 0.

    ``ask`` is whether the page asks what the last action did, ``spoken`` what a screen reader says, ``history`` what
    was read after each step so far, oldest first.
    """
    step, budget, asked = len(situation.past) + 1, situation.task.budget, situation.briefing
    panel = panel_to_show(plan, situation, words)
    warned = asked.warning if step == 1 else ""
    spoken = (*panel["report"], asked.remark, warned, filled(words["step"], step=step, budget=budget) + ".")
    told = [(turn.percept, turn.remark) for turn in situation.past[1:]] + [(situation.percept, asked.remark)]
    history = (
        " ".join(filter(None, (*_report(plan, situation.task, percept, words, turn.decision.joint), remark)))
        for turn, (percept, remark) in zip(situation.past, told, strict=False)
    )
    return {
        "kind": "box",
        "practice": number == 0,
        "number": number,
        "of": of,
        "step": step,
        "budget": budget,
        "ask": is_asked(situation),
        "panel": panel,
        "remark": asked.remark,
        "warning": asked.warning,
        "spoken": " ".join(filter(None, spoken)),
        "history": tuple(history) if experiment.history else (),
        "device": experiment.device,
    }


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did; models cannot either where no action is named."""
    return situation.task.assessment and situation.percept.joint is not None


def panel_to_show(plan: Plan, situation: Situation, words: Sentences) -> dict[str, Any]:
    """What the agent's channel shows now: the report in sentences, and each joint as it was told to be.

    Places and kinds of joints are only in a drawn panel.
    """
    task, percept, past = situation.task, situation.percept, situation.past
    view = view_of_modality(plan.modality)
    joints = tuple(
        {
            "label": label,
            "target": label == task.target,
            "kind": plan.box.joints[place].kind if view == "panel" else None,
            "place": task.places[i] if view == "panel" else None,
            "position": None if percept.positions is None else int(percept.positions[i]),
        }
        for i, (label, place) in enumerate(zip(task.joints, Names(plan).order, strict=True))
    )
    pictures = (base64.b64encode(picture.png).decode("ascii") for picture in percept.pictures if picture.shown)
    return {
        "view": view,
        "joints": joints,
        "report": _report(plan, task, percept, words, past[-1].decision.joint if past else ""),
        "last": percept.joint,
        "outcome": percept.outcome,
        "pictures": tuple(f"data:image/png;base64,{picture}" for picture in pictures),
    }


def _report(plan: Plan, task: Task, percept: Percept, words: Sentences, chosen: str) -> tuple[str, ...]:
    """What is told of an attempt, in the sentences of the page: the same to read, to hear and in the history.

    It is as it stands where an intervention acts on its words or corrects them. ``chosen`` is the joint that was
    chosen; empty before the first step.
    """
    channel, joint = shown(plan.modality), percept.joint or chosen
    if isinstance(channel, TextChannel) and percept.text != channel.written(percept, task, first=not chosen):
        return (percept.text,)
    if percept.outcome is not None:
        found = [filled(words[percept.outcome], label=joint)]
    else:
        found = [filled(words["attempted"], label=joint) if joint else words["first"]]
    if percept.positions is not None:
        ones = [label for label, position in zip(task.joints, percept.positions, strict=True) if position]
        if percept.joint is not None:
            found.append(filled(words["now"], label=joint, position=int(joint in ones)))
        found.append(filled(words["positions"], labels=", ".join(ones) or words["none"]))
    elif joint and percept.outcome is None and not percept.pictures:
        found.append(words["no_report"])
    return tuple(found)
