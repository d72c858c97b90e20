"""Reads the values in a reply: joint, claim, hypothesis. Another spelling is accepted where it has one reading."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from lockprobe.agents.reply_text import plain_form
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.record import Outcome, Situation
from lockprobe.trial.told_outcome import in_words

CLAIMS: Mapping[str, Outcome | None] = {in_words("moved"): "moved", in_words("blocked"): "blocked", "none": None}
"""The claims that a reply may make about the last action; ``none`` in the first step only."""

LONGEST_HYPOTHESIS = 4000
"""Characters."""

_JOINT = ("", "the", "joint", "thejoint")
_MOVED = ("moved", "hasmoved", "didmove")
_BLOCKED = ("didnotmove", "didntmove", "notmoved", "hasnotmoved", "hasntmoved")
_NOTHING = ("", "none", "null", "nothing", "na", "n/a")


class Values(NamedTuple):
    """The values of a reply; ``respelled`` if one was spelled in another way than asked for."""

    joint: str
    claimed: Outcome | None
    hypothesis: str
    respelled: bool


def values_in(fields: Mapping[str, object], asked: Sequence[str], claims: Sequence[str], now: Situation) -> Values:
    """The values of the fields asked for.

    Args:
        fields: The fields of the reply.
        asked: The names of those asked for; all but the hypothesis are needed.
        claims: The allowed claims about the last action.
        now: The situation that the reply is about.

    Raises:
        ReplyFault: If one is missing, or has no reading or several.
    """
    readers: dict[str, Callable[[object], object]] = {
        "joint": lambda value: _joint(value, now.task.joints),
        "last_action": lambda value: _claim(value, claims, now.percept.joint),
        "hypothesis": _sentence,
    }
    read: dict[str, object] = {}
    respelled = False
    for name in asked:
        optional = name == "hypothesis" or (name == "last_action" and claims == ["none"])
        if fields.get(name) is None and not optional:
            raise ReplyFault(f"{name}: Field required")
        read[name] = readers[name](fields.get(name))
        unlike = type(fields.get(name)) is not type(read[name]) or fields[name] != read[name]
        respelled |= unlike and not (name == "hypothesis" and name not in fields)
    claim = read.get("last_action")
    return Values(
        joint=str(read["joint"]),
        claimed=None if claim is None else CLAIMS[str(claim)],
        hypothesis=str(read.get("hypothesis", "")),
        respelled=respelled,
    )


def _only(value: object) -> object:
    """The one value in a list of one."""
    return value[0] if isinstance(value, list) and len(value) == 1 else value


def _joint(value: object, joints: Sequence[str]) -> str:
    value = _only(value)
    if value in joints:
        return str(value)
    if isinstance(value, str | int) and not isinstance(value, bool):
        plain = plain_form(str(value)).rstrip("!")
        meant = [joint for joint in joints if plain in {f"{what}{plain_form(joint)}" for what in _JOINT}]
        if len(meant) == 1:
            return meant[0]
    raise _none_of("joint", value, joints)


def _claim(value: object, claims: Sequence[str], last: str | None) -> str:
    value = _only(value)
    if value in claims:
        return str(value)
    if claims == ["none"] and (value is None or (isinstance(value, str) and plain_form(value) in _NOTHING)):
        return "none"
    if isinstance(value, str):
        plain = plain_form(value).rstrip("!")
        subjects = ("", "it", "joint", "thejoint", *(f"{what}{plain_form(last or '')}" for what in _JOINT))
        for claim, forms in (("moved", _MOVED), ("did not move", _BLOCKED)):
            if claim in claims and plain in {f"{subject}{form}" for subject in subjects for form in forms}:
                return claim
    raise _none_of("last_action", value, claims)


def _sentence(value: object) -> str:
    said = value if isinstance(value, str) else "" if value is None else json.dumps(value, ensure_ascii=False)
    said = said.encode("utf-8", "replace").decode("utf-8")  # half of a character outside the basic plane
    if len(said) > LONGEST_HYPOTHESIS:
        raise ReplyFault(f"hypothesis: {len(said)} characters, at most {LONGEST_HYPOTHESIS}")
    return said


def _none_of(name: str, value: object, allowed: Sequence[str]) -> ReplyFault:
    return ReplyFault(f"{name}: {repr(value)[:80]} is none of {', '.join(allowed)}")
