"""One trial as a line of text: a JSON array, actions with separators between them, or one character per action."""

from __future__ import annotations

import json
import re

from lockprobe.foundation.errors import BadValue

_SEPARATORS = (r"[\s,]+", r"\s*;\s*", r"\s*\|\s*", r"\s*(?:[-=]+>|[\u2192\u21d2\u27f6])\s*")
"""What stands between actions; a line has one kind."""

_ACTION = re.compile(r"[+-]?[^\W_][\w'+-]*")

_EXPECTED = 'actions with blanks, commas, ";", "|" or "->" between them, or a JSON array such as ["A", "B"]'


def parse_sequence(line: str) -> tuple[str, ...]:
    """Read one trial from a line of text.

    Actions are separated by blanks or commas, or by ``;``, ``|`` or ``->``. A line without any separator is read one
    action per character: ``ABCABC`` is six actions (and ``slider1`` seven: write ``slider1,`` for a trial of that one
    action). A JSON array holds actions of any name; so does the only array of a JSON object, for example a line
    ``{"trial": 1, "actions": ["A", "B"]}``. A line is refused if punctuation would be an action or part of one.

    >>> parse_sequence("left, right up")
    ('left', 'right', 'up')
    """
    text = line.strip()
    if text[:1] in ("[", "{"):
        return _from_json(text)
    actions = [*text]
    for separator in _SEPARATORS:
        if re.search(separator, text):
            actions = [part for part in re.split(separator, text) if part]
    if not all(map(_ACTION.fullmatch, actions)):
        raise BadValue("sequence", _short(text), _EXPECTED)
    return tuple(actions)


def _from_json(text: str) -> tuple[str, ...]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    arrays = [one for one in found.values() if isinstance(one, list)] if isinstance(found, dict) else [found]
    actions = arrays[0] if len(arrays) == 1 and isinstance(arrays[0], list) else [None]
    if {*map(type, actions)} not in ({str}, {int}, set()):
        raise BadValue("sequence", _short(text), "one JSON array of names, or of whole numbers, a line")
    return tuple(map(str, actions))


def _short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:39]}…"
