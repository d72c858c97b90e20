"""Rebuilds the conversation of a finished trial from its record."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.agents.prompt import Message, check_template, conversation, instructions, parse_reply, repair, spoken
from lockprobe.foundation.errors import ReplyFault
from lockprobe.foundation.inputs import read_input
from lockprobe.interventions.hypothesis import Hypothesis
from lockprobe.interventions.prompt import OwnPrompt
from lockprobe.interventions.warn import Warn
from lockprobe.interventions.words import Tell, TextChannel
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.record import Decision, Fact, Percept, Situation, Step, Task, Trial, Turn
from lockprobe.trial.told_outcome import in_words

__all__ = ["Exchange", "briefing_of", "exchanges_of", "instruction", "last_report"]

_BOTH: Tell = "both"
"""The default content of reports in words, if a record does not name it."""

_SHOWN: tuple[PictureKind, ...] = ("rgb", "depth")
"""Kinds of pictures that an agent sees; others are only recorded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Exchange:
    """One message to an agent, and its answer.

    Attributes:
        step: The step to decide, from 1.
        turn: The number of the answer for that step, from 1; later ones follow a malformed one.
        last: Whether it is the last answer for that step, which was acted on if it was well formed.
        asked: The whole conversation before this answer, as sent: without malformed answers to earlier steps, and
            without older pictures if only the newest are sent.
        reply: The answer; for an agent without words, its choice.
    """

    step: int
    turn: int
    last: bool
    asked: tuple[Message, ...]
    reply: str

    @property
    def told(self) -> Message:
        """The last message to the agent."""
        return self.asked[-1]


def exchanges_of(trial: Trial, pictures: Path | None = None) -> list[Exchange]:
    """The exchanges of a trial in order, without the last observation, which no decision follows.

    ``pictures`` is the directory of the pictures that the record names; missing ones are left out.
    """
    found: list[Exchange] = []
    past: list[Turn] = []
    percept = _percept(None, trial.opening, trial.opening_pictures, pictures)
    for step in trial.steps:
        replies = _words(step)
        briefing = replace(briefing_of(trial), remark=step.remark)
        situation = Situation(task=_task(trial), past=tuple(past), percept=percept, briefing=briefing)
        found += _turns(trial, situation, replies)
        past.append(Turn(percept=percept, decision=replace(step.decision, replies=replies), remark=step.remark))
        percept = _percept(step.decision, step.told, step.pictures, pictures)
    if trial.error is not None:
        situation = Situation(task=_task(trial), past=tuple(past), percept=percept, briefing=briefing_of(trial))
        found += _turns(trial, situation, trial.error.replies)
    return found


def last_report(trial: Trial, pictures: Path | None = None) -> Message:
    """The report after the last step."""
    if not trial.steps:
        opening = f"{instruction(trial)}\n\n{trial.opening}".strip()
        return Message(role="user", text=opening, pictures=_seen(trial.opening_pictures, pictures))
    return Message(role="user", text=trial.steps[-1].told, pictures=_seen(trial.steps[-1].pictures, pictures))


def instruction(trial: Trial) -> str:
    """The instruction to a hosted model, word for word; for other agents, a description of their trial."""
    task = _task(trial)
    if not str(trial.facts.get("prompt", "")).startswith("chat "):
        return f"Joints {', '.join(task.joints)}; the target is {task.target}; {task.budget} steps."
    shown = sum(kind in _SHOWN for kind in trial.opening_pictures)
    last = (_named(trial.channels, TextChannel) or [{}])[-1]  # the last channel of words
    tell = str(last.get("tell", _BOTH))
    positions = not shown and tell != "outcome"
    return instructions(
        task,
        positions=positions,
        outcomes=tell != "state",
        in_full=last.get("form", "words") != "words",
        pictures=shown,
        labelled=trial.plant.get("labels") is not False,
        briefing=briefing_of(trial),
    )


def briefing_of(trial: Trial) -> Briefing:
    """The briefing of every step without remarks, from the recorded interventions that ship with Lockprobe.

    Raises:
        UserMistake: As :func:`lockprobe.agents.prompt.check_template`.
    """
    briefing = Briefing(hypothesis=trial.hypothesis)
    for one in trial.interventions:
        ask = _ASKED.get(str(one.get("intervention")))
        briefing = briefing if ask is None else ask(briefing, one)
    return briefing


def _own(briefing: Briefing, one: Mapping[str, Fact]) -> Briefing:
    text = str(one.get("text", ""))
    check_template(text)
    return replace(briefing, instruction=text)


def _warned(briefing: Briefing, one: Mapping[str, Fact]) -> Briefing:
    rate = one.get("rate")
    return briefing.warning_of(Warn(rate=float(rate) if isinstance(rate, int | float) else None).sentence)


def _hypothesis(briefing: Briefing, one: Mapping[str, Fact]) -> Briefing:
    return replace(briefing, hypothesis=Hypothesis(ask=str(one.get("ask", "before"))).ask)  # type: ignore[arg-type]


_ASKED: Mapping[str, Callable[[Briefing, Mapping[str, Fact]], Briefing]] = {
    OwnPrompt.__name__: _own,
    Warn.__name__: _warned,
    Hypothesis.__name__: _hypothesis,
}
"""The change of the briefing by each intervention on what is asked, by its class name in records."""


def _named(channels: tuple[Mapping[str, Fact], ...], kind: type) -> list[Mapping[str, Fact]]:
    return [channel for channel in channels if channel.get("channel") == kind.__name__]


def _task(trial: Trial) -> Task:
    label = dict(zip(trial.joints, trial.labels, strict=True))[trial.target]
    return Task(joints=trial.listing, target=label, budget=trial.budget, assessment=trial.assessment)


def _words(step: Step) -> tuple[str, ...]:
    decision = step.decision
    if decision.replies:
        return decision.replies
    said = f"It {in_words(decision.claimed)}." if decision.claimed else ""
    return (f"({' '.join(filter(None, (said, decision.hypothesis, f'Attempts {decision.joint}.')))})",)


def _turns(trial: Trial, situation: Situation, replies: tuple[str, ...]) -> list[Exchange]:
    """The answers of one step; every answer after the first follows a malformed one."""
    images = trial.facts.get("images")
    first, *others = conversation(situation, images=images if isinstance(images, int) else 0)
    opening = situation.past[0].percept if situation.past else situation.percept
    by_pictures = instructions(
        situation.task, positions=False, pictures=len(opening.pictures), briefing=situation.briefing
    )
    told = first.text.removeprefix(by_pictures).removeprefix("\n\n")
    asked = (replace(first, text=f"{instruction(trial)}\n\n{told}".strip()), *others)
    found, step = [], len(situation.past) + 1
    for turn, reply in enumerate(replies, 1):
        found.append(Exchange(step=step, turn=turn, last=turn == len(replies), asked=asked, reply=reply))
        try:
            parse_reply(reply, situation)
        except ReplyFault as fault:
            again = Message(role="user", text=repair(fault, situation))
            asked = (*asked, Message(role="assistant", text=spoken(reply)), again)
    return found


def _percept(before: Decision | None, text: str, names: Mapping[PictureKind, str], directory: Path | None) -> Percept:
    return Percept(joint=None if before is None else before.joint, text=text, pictures=_seen(names, directory))


def _seen(names: Mapping[PictureKind, str], directory: Path | None) -> tuple[Picture, ...]:
    files = [] if directory is None else [(kind, directory / names[kind]) for kind in _SHOWN if kind in names]
    return tuple(Picture(kind=kind, png=read_input(file)) for kind, file in files if file.is_file())
