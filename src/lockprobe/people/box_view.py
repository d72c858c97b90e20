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

    ``ask`` is whether the page asks what the last action did, ``spoken`` what a screen reader says: also what the panel
    shows. ``history`` is what was told after each step so far, oldest first.
    """
    step, budget, asked = len(situation.past) + 1, situation.task.budget, situation.briefing
    panel = panel_to_show(plan, situation, words)
    # a panel is drawn: who cannot see it hears all that was told
    drawn = panel["view"] == "panel" and (situation.percept.joint is not None or situation.past)
    first = not situation.past
    told = (drawn and _sentences(plan, situation.task, situation.percept, words, first=first)) or panel["report"]
    warned = asked.warning if step == 1 else ""
    spoken = (*told, asked.remark, warned, filled(words["step"], step=step, budget=budget) + ".")
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
        "history": _history(plan, situation, words) if experiment.history else (),
        "history_open": experiment.history_open,
        "device": experiment.device,
    }


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did; models cannot either where no action is named."""
    return situation.task.assessment and situation.percept.joint is not None


def panel_to_show(plan: Plan, situation: Situation, words: Sentences) -> dict[str, Any]:
    """What the agent's channel shows now: the report in sentences, and each joint as it was told to be.

    Places and kinds of joints are only in a drawn panel; ``handle`` is where pictures show it at each position.
    """
    task, percept = situation.task, situation.percept
    view = view_of_modality(plan.modality)
    handles = _handles(percept) if view == "pictures" else {}
    joints = tuple(
        {
            "label": label,
            "target": label == task.target,
            "kind": plan.box.joints[place].kind if view == "panel" else None,
            "place": task.places[i] if view == "panel" else None,
            "position": None if percept.positions is None else int(percept.positions[i]),
            "handle": handles.get(i),
        }
        for i, (label, place) in enumerate(zip(task.joints, Names(plan).order, strict=True))
    )
    pictures = (base64.b64encode(picture.png).decode("ascii") for picture in percept.pictures if picture.shown)
    return {
        "view": view,
        "joints": joints,
        "report": _report(plan, situation, words),
        "last": percept.joint,
        "outcome": percept.outcome,
        "pictures": tuple(f"data:image/png;base64,{picture}" for picture in pictures),
    }


def read_of_step(plan: Plan, situation: Situation, words: Sentences) -> str:
    """What a participant reads of the last step: the report and a remark with it."""
    return " ".join(filter(None, (*_report(plan, situation, words), situation.briefing.remark)))


def _report(plan: Plan, situation: Situation, words: Sentences) -> tuple[str, ...]:
    """What came of the last attempt, in words; what the panel shows is not said again."""
    task, percept, first = situation.task, situation.percept, not situation.past
    told, verbatim = _sentences(plan, task, percept, words, first=first), _is_verbatim(plan, task, percept, first=first)
    if percept.joint is None and first:
        return (words["first"], *(told if verbatim else ()))
    if percept.pictures:
        return (filled(words["seen"], label=percept.joint),)
    if verbatim or not told:
        return told or (words["no_report"],)
    return told[:2] if percept.joint is not None and percept.positions is not None else told[:1]


def _sentences(plan: Plan, task: Task, percept: Percept, words: Sentences, *, first: bool = False) -> tuple[str, ...]:
    """A report in the sentences of the page, or as it is where an intervention acts on its words or corrects them.

    Nothing where nothing was reported, and with pictures.
    """
    if _is_verbatim(plan, task, percept, first=first):
        return (percept.text,)
    joint, found, ones = percept.joint, list[str](), None
    if percept.positions is not None:
        ones = [label for label, position in zip(task.joints, percept.positions, strict=True) if position]
    if percept.outcome is not None:
        found.append(filled(words[percept.outcome], label=joint))
    elif ones is not None and joint is not None:
        found.append(filled(words["attempted"], label=joint))
    if ones is not None:
        if joint is not None:
            found.append(filled(words["now"], label=joint, position=int(joint in ones)))
        found.append(filled(words["positions"], labels=", ".join(ones) or words["none"]))
    return tuple(found)


def _history(plan: Plan, situation: Situation, words: Sentences) -> tuple[str, ...]:
    """What was told after each step so far, oldest first."""
    after = [(turn.percept, turn.remark) for turn in situation.past[1:]]
    after.append((situation.percept, situation.briefing.remark))
    lines = []
    for turn, (percept, remark) in zip(situation.past, after, strict=False):
        said = () if percept.pictures else _sentences(plan, situation.task, percept, words)
        said = said or (filled(words["joint"], label=turn.decision.joint),)
        lines.append(" ".join(filter(None, (*said, remark))))
    return tuple(lines)


def _is_verbatim(plan: Plan, task: Task, percept: Percept, *, first: bool = False) -> bool:
    """Whether the words of a report say something else than its facts do in the sentences of its modality."""
    channel = shown(plan.modality)
    return isinstance(channel, TextChannel) and percept.text != channel.written(percept, task, first=first)


def _handles(percept: Percept) -> dict[int, tuple[tuple[float, float], ...]]:
    """Where handles lie, as shares of the pictures; a place in pixels counts from the middle of the first pixel."""
    if not percept.pictures:
        return {}
    header = percept.pictures[0].png[16:24]  # of the first chunk of a PNG file
    width, height = int.from_bytes(header[:4], "big"), int.from_bytes(header[4:], "big")
    return {
        i: tuple((round((x + 0.5) / width, 5), round((y + 0.5) / height, 5)) for x, y in places)
        for i, places in enumerate(percept.handles)
    }
