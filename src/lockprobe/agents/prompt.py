"""The prompt of a language model and the form of its reply (paper, Sec. 2.2).

The instruction is the same for every trial and condition; only its words on the observation follow the modality. It
states the problem, names the joints and the target, and says nothing about which joint locks which. Where pictures are
shown, positions have no names, and the model has to find out what an action did. The paper prints no prompt, so the
wording is ours.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from lockprobe.agents.reply import asked_for, spoken
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.pictures.picture import Picture, PictureKind
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

INSTRUCTIONS = """\
You are trying to open a lockbox, a panel with {count} joints.
Every joint has two positions{names}. The joints lock each other in a hidden way: whether a joint can move \
depends on the positions of other joints. If you attempt a joint that is not locked, it moves to its other \
position; if it is locked, nothing happens.
The box is open as soon as the target joint moves. You have {budget} steps. In every step you choose one joint to \
attempt. {observation}
{reply}
The panel's joints: {joints}. The target joint: {target}."""
"""What is of one trial alone stands last: all trials of a condition share the rest, and providers' prefix caches it."""

FIELDS = ("joints", "target", "reply", "budget", "count", "names", "observation")
"""Fields of an instruction: the labels as listed; the target's; the form of the reply, as a sentence; the steps; how
many joints; what positions are called; what is told after a step. The first three are required."""

_OBSERVATION = {
    (True, True): "Then you are told whether it moved, and {told}.",
    (False, True): "Then you are told whether it moved.",
    (True, False): "Then you are told {told}. You are not told whether a joint moved: find out by comparing successive "
    "reports.",
}
"""By whether positions are told, and outcomes."""

_POSITIONS = {False: "which joints are now at position 1", True: "the position of every joint"}
"""By whether the position of every joint is told, or only which are at 1."""

_ASKED = {
    "last_action": '"moved" or "did not move" ("none" in the first step)',
    "joint": "the joint to attempt next",
    "hypothesis": 'a short sentence on how the box works or ""',
}
"""How the fields of a reply are asked for."""

_SEEN = """\
Before every step you are shown {pictures}, always taken from the same place; {labels}. \
You are not told whether a joint moved: find out by comparing successive pictures."""
_LABELS = {
    True: "beside every joint its label is painted on the panel",
    False: "no labels are painted on the panel, and with the first picture you are told where the joints lie",
}
"""By whether labels can be seen."""

_PICTURES = {1: "a picture of the box", 2: "two pictures of the box, one of its colours and one of its depth"}
_GONE = {1: "(picture no longer shown)", 2: "(pictures no longer shown)"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """One message of a conversation; its pictures come after its text."""

    role: Literal["user", "assistant"]
    text: str
    pictures: tuple[Picture, ...] = ()


def example(pictures: int = 0, *, assessment: bool = True) -> Situation:
    """The second step of a made-up trial, used for fingerprints of prompts.

    Its observations show so many pictures, or reports if there are none. ``assessment`` as in :class:`Task`.
    """
    task = Task(joints=("B", "A"), target="A", budget=20, assessment=assessment)
    decision = Decision(joint="B", replies=("reply",))
    first = Percept(positions=(False, False), text="first")
    then = Percept(joint="B", outcome="moved", positions=(True, False), text="then")
    if pictures:
        kinds: tuple[PictureKind, ...] = ("rgb", "depth")
        shown = tuple(Picture(kind=kind, png=b"") for kind in kinds[:pictures])
        first, then = (replace(told, outcome=None, positions=None, pictures=shown) for told in (first, then))
    return Situation(task=task, past=(Turn(percept=first, decision=decision),), percept=then)


def fingerprint(*texts: str) -> str:
    """A fingerprint of texts: twelve hexadecimal digits."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:12]


def instructions(situation: Situation, reply: str = "") -> str:
    """The instruction at the start of a trial, by its first observation and what the agent is asked and warned of.

    ``reply`` says how to reply; empty for one JSON object.
    """
    first = situation.past[0].percept if situation.past else situation.percept
    task, briefing, pictures = situation.task, situation.briefing, len(first.shown)
    if pictures:
        observation = _SEEN.format(pictures=_PICTURES[pictures], labels=_LABELS[not first.unlabelled])
    else:
        told = first.positions is not None, not first.states_only or first.positions is None
        observation = _OBSERVATION[told].format(told=_POSITIONS[first.in_full])
    template, warning = briefing.instruction or INSTRUCTIONS, briefing.warning
    items = ", ".join(f'"{name}": {_ASKED[name]}' for name in asked_for(situation))
    text = template.format(
        count=len(task.joints),
        joints=", ".join(task.joints),
        target=task.target,
        budget=task.budget,
        names="" if pictures else ", 0 and 1",
        observation=f"{observation} {warning}".rstrip(),
        reply=reply or f"Reply with one JSON object and nothing else:\n{{{items}}}",
    )
    return text if warning in text else f"{text} {warning}"


def conversation(situation: Situation, *, images: int = 0) -> list[Message]:
    """The whole conversation up to now: instruction and first observation, then reply and observation in turn.

    The newest ``images`` observations keep their pictures, all if 0. Older ones say that theirs are gone.
    """
    told = list[Message]()
    for left, (percept, remark) in zip(range(len(situation.past), -1, -1), situation.told, strict=True):
        gone = _GONE[len(percept.shown)] if percept.shown and images and left >= images else ""
        text = " ".join(filter(None, (percept.text, gone, remark)))
        told.append(Message(role="user", text=text, pictures=() if gone else percept.shown))
    messages = [replace(told[0], text=f"{instructions(situation)}\n\n{told[0].text}".strip())]
    for turn, observation in zip(situation.past, told[1:], strict=True):
        messages += [Message(role="assistant", text=spoken(turn.decision.replies[-1])), observation]
    return messages


def reply_schema(fields: Mapping[str, Sequence[str]]) -> dict[str, object]:
    """The JSON schema of a reply with these fields, and the values that each may have; any text if there are none."""
    properties = {
        name: {"type": "string", "enum": list(allowed)} if allowed else {"type": "string"}
        for name, allowed in fields.items()
    }
    return {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def repair(fault: ReplyFault, situation: Situation) -> str:
    """The message to a model after a malformed reply."""
    asked = asked_for(situation)
    again = {
        "last_action": " or ".join(map(json.dumps, asked.get("last_action", ()))),
        "joint": f"one of {json.dumps(asked['joint'])}",
        "hypothesis": '""',
    }
    items = ", ".join(f'"{name}": {again[name]}' for name in asked)
    return f"That reply could not be used ({fault}). Reply with one JSON object and nothing else: {{{items}}}"


def prompt_fingerprint() -> str:
    """A fingerprint of the words of all conversations, except the observations."""
    texts = [*_OBSERVATION.values(), *_POSITIONS.values(), *_LABELS.values()]
    for shown in (example(), example(assessment=False), example(1), example(2)):
        texts += [message.text for message in conversation(shown, images=1)]
        texts += [repair(ReplyFault("why"), shown), json.dumps(reply_schema(asked_for(shown)))]
    return f"chat {fingerprint(*texts)}"
