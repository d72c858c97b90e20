"""The conversation of a finished trial, made again from its record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.prompt import Message, instructions, parse_reply, repair
from lockprobe.errors import ReplyFault
from lockprobe.pictures.picture import Picture, PictureKind
from lockprobe.record import Percept, Situation, Step, Task, Trial

__all__ = ["Exchange", "instruction", "retold", "told_last"]

_SHOWN: tuple[PictureKind, ...] = ("rgb", "depth")
"""Kinds of pictures that an agent sees; others are kept for the record."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Exchange:
    """What an agent was told, and what it answered.

    Attributes:
        step: The step that was to be decided, from 1.
        turn: Which answer for that step, from 1; those after the first follow a malformed one.
        last: Whether it is the last answer for that step, which was acted on if it was of the form asked for.
        told: What it was told.
        reply: What it answered; of an agent that has no words, what it chose.
    """

    step: int
    turn: int
    last: bool
    told: Message
    reply: str


def retold(trial: Trial, pictures: Path | None = None) -> list[Exchange]:
    """What was said in a trial, in order; the last observation, after which nothing was decided, is left out.

    Args:
        trial: The trial.
        pictures: Directory of the pictures that its record names; without it, or where one is missing, there is none.
    """
    found: list[Exchange] = []
    told = _message(_opening(trial), trial.opening_pictures, pictures)
    for step in trial.steps:
        found += _turns(trial, step.step, told, _words(step))
        told = _message(step.told, step.pictures, pictures)
    if trial.error is not None:
        found += _turns(trial, trial.error.step, told, trial.error.replies)
    return found


def told_last(trial: Trial, pictures: Path | None = None) -> Message:
    """What was told after the last step."""
    if not trial.steps:
        return _message(_opening(trial), trial.opening_pictures, pictures)
    return _message(trial.steps[-1].told, trial.steps[-1].pictures, pictures)


def instruction(trial: Trial) -> str:
    """The instruction as a hosted model gets it, word for word; of other agents, what their trial was about."""
    task = _task(trial)
    if not str(trial.facts.get("prompt", "")).startswith("chat "):
        return f"Joints {', '.join(task.joints)}; the target is {task.target}; {task.budget} steps."
    shown = sum(kind in _SHOWN for kind in trial.opening_pictures)
    return instructions(task, positions=not shown and trial.flip != "outcome-only", pictures=shown)


def _opening(trial: Trial) -> str:
    return f"{instruction(trial)}\n\n{trial.opening}".strip()


def _task(trial: Trial) -> Task:
    label = dict(zip(trial.joints, trial.labels, strict=True))[trial.target]
    return Task(joints=trial.listing, target=label, budget=trial.budget, assessment=trial.assessment)


def _words(step: Step) -> tuple[str, ...]:
    decision = step.decision
    if decision.replies:
        return decision.replies
    said = {"moved": "It moved. ", "blocked": "It did not move. ", None: ""}[decision.claimed]
    return (f"({said}{decision.hypothesis} Attempts {decision.joint}.)".replace("( ", "("),)


def _turns(trial: Trial, step: int, told: Message, replies: tuple[str, ...]) -> list[Exchange]:
    """The answers of one step: each but the first follows a malformed one, which was asked for again."""
    situation = Situation(
        task=_task(trial), past=(), percept=Percept(joint=None if step == 1 else trial.steps[step - 2].decision.joint)
    )
    found = []
    for turn, reply in enumerate(replies, 1):
        found.append(Exchange(step=step, turn=turn, last=turn == len(replies), told=told, reply=reply))
        try:
            parse_reply(reply, situation)
        except ReplyFault as fault:
            told = Message(role="user", text=repair(fault, situation))
    return found


def _message(text: str, names: Mapping[PictureKind, str], directory: Path | None) -> Message:
    files = [] if directory is None else [(kind, directory / names[kind]) for kind in _SHOWN if kind in names]
    shown = tuple(Picture(kind=kind, png=file.read_bytes()) for kind, file in files if file.is_file())
    return Message(role="user", text=text, pictures=shown)
