"""What a language model is told, and the form of its reply (paper, Sec. 2.2).

The instruction is the same for every trial and condition; only what it says of the observation follows the modality.
Where pictures are shown, positions have no names, and what an action did is for the model to find out. It states the
problem, names the joints and the target, and says nothing about which joint locks which.
The paper prints no prompt, so the wording is ours.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.errors import ReplyFault
from lockprobe.pictures.picture import Picture, PictureKind
from lockprobe.record import Decision, Outcome, Percept, Situation, Task, Turn

__all__ = [
    "Message",
    "Reply",
    "chat_fingerprint",
    "claims",
    "conversation",
    "example",
    "fingerprint",
    "instructions",
    "parse_reply",
    "picture_fingerprint",
    "repair",
    "reply_schema",
]

_CLAIMS: dict[str, Outcome | None] = {"moved": "moved", "did not move": "blocked", "none": None}
"""What a reply may say of the last action."""

_INSTRUCTIONS = """\
You are trying to open a lockbox, a panel with {count} joints.
Every joint has two positions{names}. The joints lock each other in a hidden way: whether a joint can move \
depends on the positions of other joints. If you attempt a joint that is not locked, it moves to its other \
position; if it is locked, nothing happens.
The box is open as soon as the target joint moves. You have {budget} steps. In every step you choose one joint to \
attempt. {observation}
Reply with one JSON object and nothing else:
{{{assessment}"hypothesis": a short sentence on how the box works or "", "joint": the joint to attempt next}}
The panel's joints: {listing}. The target joint: {target}."""
"""What is of one trial alone stands last: all trials of a condition share the rest, and providers' prefix caches it."""

_ASSESSMENT = '"last_action": "moved" or "did not move" ("none" in the first step), '
"""What is asked of the last action, if anything is."""

_OBSERVATION = {
    (True, True): "Then you are told whether it moved, and which joints are now at position 1.",
    (False, True): "Then you are told whether it moved.",
    (
        True,
        False,
    ): "Then you are told which joints are now at position 1. You are not told whether a joint moved: find out "
    "by comparing successive reports.",
}
"""By whether positions are told, and outcomes."""

_SEEN = """\
Before every step you are shown {pictures}, always taken from the same place; beside every joint its label is painted \
on the panel. You are not told whether a joint moved: find out by comparing successive pictures."""
_PICTURES = {1: "a picture of the box", 2: "two pictures of the box, one of its colours and one of its depth"}
_GONE = {1: "(picture no longer shown)", 2: "(pictures no longer shown)"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """One message of a conversation; its pictures come after its text."""

    role: Literal["user", "assistant"]
    text: str
    pictures: tuple[Picture, ...] = ()


def example(pictures: int = 0, *, assessment: bool = True) -> Situation:
    """The second step of a made-up trial: what a prompt looks like, and what its fingerprint is taken from.

    Args:
        pictures: How many an observation shows. Where there are some, it tells nothing else.
        assessment: Whether it is asked what the last action did.
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
    """Twelve hexadecimal digits that change with any of the texts."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:12]


class Reply(BaseModel):
    """The form of a reply."""

    model_config = ConfigDict(extra="ignore")

    last_action: Literal["moved", "did not move", "none"] | None = None
    hypothesis: str = Field(default="", max_length=4000)
    joint: str


def instructions(task: Task, *, positions: bool, outcomes: bool = True, pictures: int = 0, warning: str = "") -> str:
    """The instruction at the start of a trial.

    Args:
        task: What the agent may know.
        positions: Whether the observations tell positions, or outcomes only.
        outcomes: Whether they tell outcomes, or positions only.
        pictures: How many pictures an observation shows: none, one of colours, or that and one of depth. Where there
            are some, the observations tell nothing else.
        warning: What is said of the reports; often empty.
    """
    observation = (
        _SEEN.format(pictures=_PICTURES[pictures]) if pictures else _OBSERVATION[positions, outcomes or not positions]
    )
    return _INSTRUCTIONS.format(
        count=len(task.joints),
        listing=", ".join(task.joints),
        target=task.target,
        budget=task.budget,
        names="" if pictures else ", 0 and 1",
        observation=f"{observation} {warning}".rstrip(),
        assessment=_ASSESSMENT if task.assessment else "",
    )


def conversation(situation: Situation, *, images: int = 0) -> list[Message]:
    """The whole conversation up to now: instruction and first observation, then reply and observation in turn.

    Args:
        situation: The task, the past and what is to be told now.
        images: How many observations, the newest, keep their pictures; 0 for all. Older ones say that theirs are gone.
    """
    percepts = [*(turn.percept for turn in situation.past), situation.percept]
    remarks = [*(turn.remark for turn in situation.past), situation.briefing.remark]
    newest_first = enumerate(zip(reversed(percepts), reversed(remarks), strict=True))
    told = [_observation(percept, said, keep=not images or i < images) for i, (percept, said) in newest_first][::-1]
    opening = instructions(
        situation.task,
        positions=percepts[0].positions is not None,
        outcomes=not percepts[0].states_only,
        pictures=len(_shown(percepts[0])),
        warning=situation.briefing.warning,
    )
    messages = [replace(told[0], text=f"{opening}\n\n{told[0].text}".strip())]
    for turn, observation in zip(situation.past, told[1:], strict=True):
        messages += [Message(role="assistant", text=turn.decision.replies[-1]), observation]
    return messages


def _observation(percept: Percept, remark: str, *, keep: bool) -> Message:
    shown = _shown(percept)
    gone = "" if not shown or keep else _GONE[len(shown)]
    text = " ".join(filter(None, (percept.text, gone, remark)))
    return Message(role="user", text=text, pictures=() if gone else shown)


def _shown(percept: Percept) -> tuple[Picture, ...]:
    return tuple(picture for picture in percept.pictures if picture.shown)


def claims(situation: Situation) -> list[str]:
    """What a reply may say of the last action now: ``none`` in the first step only, and nothing if nobody asks."""
    if not situation.task.assessment:
        return []
    return ["none"] if situation.percept.joint is None else ["moved", "did not move"]


def reply_schema(situation: Situation) -> dict[str, object]:
    """The reply as a JSON schema, with what may be said in this step."""
    asked = {"last_action": {"type": "string", "enum": said}} if (said := claims(situation)) else {}
    properties = asked | {
        "hypothesis": {"type": "string"},
        "joint": {"type": "string", "enum": list(situation.task.joints)},
    }
    return {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def parse_reply(text: str, situation: Situation) -> Decision:
    """The decision in a raw reply. A fence of backticks around the object is forgiven, nothing else.

    Raises:
        ReplyFault: If it is not the object that was asked for, saying why.
    """
    body, asked = text.strip(), claims(situation)
    if body.startswith("```") and body.endswith("```"):
        body = body.strip("`").removeprefix("json").strip()
    try:
        found = json.loads(body)
        if not asked and isinstance(found, dict):
            found.pop("last_action", None)  # said without being asked
        reply = Reply.model_validate(found)
    except ValidationError as error:
        first = error.errors()[0]
        raise ReplyFault(f"{'.'.join(map(str, first['loc'])) or 'reply'}: {first['msg']}") from None
    except (ValueError, RecursionError):
        raise ReplyFault("not one JSON object") from None
    if reply.joint not in situation.task.joints:
        raise ReplyFault(f"joint: {reply.joint!r} is none of {', '.join(situation.task.joints)}")
    said = reply.last_action
    if asked and said not in asked:
        raise ReplyFault("last_action: " + (f"{said!r} is none of {', '.join(asked)}" if said else "Field required"))
    claimed = None if said is None else _CLAIMS[said]
    return Decision(joint=reply.joint, claimed=claimed, hypothesis=reply.hypothesis, replies=(text,))


def repair(fault: ReplyFault, situation: Situation) -> str:
    """What a model is told after a malformed reply."""
    said = " or ".join(json.dumps(claim) for claim in claims(situation))
    last_action = f'"last_action": {said}, ' if said else ""
    return (
        f"That reply could not be used ({fault}). Reply with one JSON object and nothing else: "
        f'{{{last_action}"hypothesis": "", "joint": one of {json.dumps(list(situation.task.joints))}}}'
    )


def chat_fingerprint() -> str:
    """What changes with any word of a conversation in which reports are told, but for those of the observation."""
    return fingerprint(*(text for assessment in (True, False) for text in _said(example(assessment=assessment))))


def _said(shown: Situation) -> list[str]:
    texts = [message.text for message in conversation(shown)]
    return [*texts, repair(ReplyFault("why"), shown), json.dumps(reply_schema(shown))]


def picture_fingerprint() -> str:
    """The same where one picture is shown, and two, with what is said of those that are no longer shown.

    It stands apart so that a study of reports recorded before there were pictures can be resumed.
    """
    conversations = (conversation(example(pictures), images=1) for pictures in (1, 2))
    return fingerprint(*(message.text for messages in conversations for message in messages))
