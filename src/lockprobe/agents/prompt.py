"""What a language model is told, and the form of its reply (paper, Sec. 2.2).

The instruction is the same for every trial and condition; only the sentence about the observation follows the
modality. It states the problem, names the joints and the target, and says nothing about which joint locks which.
The paper prints no prompt, so the wording is ours.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.errors import ReplyFault
from lockprobe.record import Decision, Outcome, Percept, Situation, Task, Turn

__all__ = [
    "Message",
    "Reply",
    "claims",
    "conversation",
    "example",
    "fingerprint",
    "instructions",
    "parse_reply",
    "repair",
    "reply_schema",
]

CLAIMS: dict[str, Outcome | None] = {"moved": "moved", "did not move": "blocked", "none": None}
"""What a reply may say of the last action."""

_INSTRUCTIONS = """\
You are trying to open a lockbox, a panel with {count} joints: {listing}.
Every joint has two positions, 0 and 1. The joints lock each other in a hidden way: whether a joint can move \
depends on the positions of other joints. If you attempt a joint that is not locked, it moves to its other \
position; if it is locked, nothing happens.
The box is open as soon as the target joint {target} moves. You have {budget} steps. In every step you choose one \
joint to attempt. {observation}
Reply with one JSON object and nothing else:
{{"last_action": "moved" or "did not move" ("none" in the first step), \
"hypothesis": a short sentence on how the box works or "", "joint": the joint to attempt next}}"""

_OBSERVATION = {
    True: "Then you are told whether it moved, and which joints are now at position 1.",
    False: "Then you are told whether it moved.",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """One message of a conversation."""

    role: Literal["user", "assistant"]
    text: str


def example() -> Situation:
    """The second step of a made-up trial: what a prompt looks like, and what its fingerprint is taken from."""
    task = Task(joints=("B", "A"), target="A", budget=20)
    decision = Decision(joint="B", replies=("reply",))
    past = (Turn(percept=Percept(positions=(False, False), text="first"), decision=decision),)
    percept = Percept(joint="B", outcome="moved", positions=(True, False), text="then")
    return Situation(task=task, past=past, percept=percept)


def fingerprint(*texts: str) -> str:
    """Twelve hexadecimal digits that change with any of the texts."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:12]


class Reply(BaseModel):
    """The form of a reply."""

    model_config = ConfigDict(extra="ignore")

    last_action: Literal["moved", "did not move", "none"]
    hypothesis: str = Field(default="", max_length=4000)
    joint: str


def instructions(task: Task, *, positions: bool) -> str:
    """The instruction at the start of a trial.

    Args:
        task: What the agent may know.
        positions: Whether the observations tell positions, or outcomes only.
    """
    return _INSTRUCTIONS.format(
        count=len(task.joints),
        listing=", ".join(task.joints),
        target=task.target,
        budget=task.budget,
        observation=_OBSERVATION[positions],
    )


def conversation(situation: Situation) -> list[Message]:
    """The whole conversation up to now: instruction and first observation, then reply and observation in turn."""
    percepts = [*(turn.percept for turn in situation.past), situation.percept]
    opening = instructions(situation.task, positions=percepts[0].positions is not None)
    messages = [Message(role="user", text=f"{opening}\n\n{percepts[0].text}".strip())]
    for turn, percept in zip(situation.past, percepts[1:], strict=True):
        messages.append(Message(role="assistant", text=turn.decision.replies[-1]))
        messages.append(Message(role="user", text=percept.text))
    return messages


def claims(situation: Situation) -> list[str]:
    """What a reply may say of the last action now; ``none`` is offered in the first step only."""
    return ["none"] if situation.percept.joint is None else ["moved", "did not move"]


def reply_schema(situation: Situation) -> dict[str, object]:
    """The reply as a JSON schema, with what may be said in this step."""
    return {
        "type": "object",
        "properties": {
            "last_action": {"type": "string", "enum": claims(situation)},
            "hypothesis": {"type": "string"},
            "joint": {"type": "string", "enum": list(situation.task.joints)},
        },
        "required": ["last_action", "hypothesis", "joint"],
        "additionalProperties": False,
    }


def parse_reply(text: str, situation: Situation) -> Decision:
    """The decision in a raw reply. A fence of backticks around the object is forgiven, nothing else.

    Raises:
        ReplyFault: If it is not the object that was asked for, saying why.
    """
    body = text.strip()
    if body.startswith("```") and body.endswith("```"):
        body = body.strip("`").removeprefix("json").strip()
    try:
        reply = Reply.model_validate(json.loads(body))
    except ValidationError as error:
        first = error.errors()[0]
        raise ReplyFault(f"{'.'.join(map(str, first['loc'])) or 'reply'}: {first['msg']}") from None
    except (ValueError, RecursionError):
        raise ReplyFault("not one JSON object") from None
    if reply.joint not in situation.task.joints:
        raise ReplyFault(f"joint: {reply.joint!r} is none of {', '.join(situation.task.joints)}")
    if reply.last_action not in claims(situation):
        raise ReplyFault(f"last_action: {reply.last_action!r} is none of {', '.join(claims(situation))}")
    return Decision(joint=reply.joint, claimed=CLAIMS[reply.last_action], hypothesis=reply.hypothesis, replies=(text,))


def repair(fault: ReplyFault, situation: Situation) -> str:
    """What a model is told after a malformed reply."""
    return (
        f"That reply could not be used ({fault}). Reply with one JSON object and nothing else: "
        f'{{"last_action": {" or ".join(json.dumps(claim) for claim in claims(situation))}, '
        f'"hypothesis": "", "joint": one of {json.dumps(list(situation.task.joints))}}}'
    )
