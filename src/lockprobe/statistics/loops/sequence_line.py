"""One trial as a line of text: a JSON array, actions with separators between them, or one character per action."""

from __future__ import annotations

import json
import re

from lockprobe.foundation.errors import BadValue

_MARKS = {";": r";", "|": r"\|", "->": r"[-=]+>|[\u2192\u21d2\u27f6]"}
"""Separators besides blanks and commas: how each is called, and its pattern. A line has one kind of them."""

_AROUND = re.compile(r"[\"\u201c\u201d]|^['\u2018]|[.:!?\u2026]$")
"""What belongs to a line or a sentence, not to an action: quotes around it, a full stop or a colon after it."""

_EXPECTED = 'one with blanks, commas, ";", "|" or "->" between actions, or a JSON array such as ["A", "B"]'


def parse_sequence(line: str) -> tuple[str, ...]:
    """Read one trial from a line of text.

    Actions are separated by blanks or commas, or by ``;``, ``|`` or ``->``, of which a line has only one kind. A line
    without any separator is read one action per character: ``ABCABC`` is six actions (and ``slider1`` seven: write
    ``slider1,`` for a trial of that one action). A JSON array holds actions of any name; so does the only array of a
    JSON object, for example a line ``{"trial": 1, "actions": ["A", "B"]}``. A line is refused if it can be read in
    several ways, or punctuation would be an action or part of one.

    >>> parse_sequence("left, right up")
    ('left', 'right', 'up')
    """
    text = line.strip()
    if text[:1] in ("[", "{"):
        return _from_json(text)
    marks = [mark for mark, pattern in _MARKS.items() if re.search(pattern, text)]
    if len(marks) > (0 if "," in text else 1):
        found = " and ".join(f'"{mark}"' for mark in ([","] * ("," in text) + marks))
        raise _refused(text, f"one kind of separator, not {found}")
    if marks:
        actions = [part.strip() for part in re.split(_MARKS[marks[0]], text) if part.strip()]
        for part in actions:
            if re.search(r"\s", part):
                raise _refused(part, f'one action between two "{marks[0]}"; a JSON array can hold it')
    else:
        actions = re.findall(r"[^\s,]+", text) if re.search(r"[\s,]", text) else list(text)
    for action in actions:
        if not any(character.isalnum() for character in action) or _is_torn(action):
            raise _refused(text, f"{_EXPECTED}: {_short(action)!r} would be an action")
    return tuple(actions)


def _is_torn(action: str) -> bool:
    """Whether punctuation of the line stands at an action: with it the same action has two names."""
    unpaired = any(
        (action.startswith(opened) or action.endswith(closed)) and action.count(opened) != action.count(closed)
        for opened, closed in ("()", "[]", "{}", "<>")
    )
    return unpaired or _AROUND.search(action) is not None


def _from_json(text: str) -> tuple[str, ...]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        raise _refused(text, _EXPECTED) from None
    if isinstance(found, dict):
        arrays = [value for value in found.values() if isinstance(value, list)]
        if len(arrays) != 1:
            raise _refused(text, f"an object with one array, not {len(arrays)}")
        (found,) = arrays
    kinds = {type(action) for action in found}
    if not kinds <= {str} and not kinds <= {int}:
        raise _refused(text, "a JSON array of names, or of whole numbers; one array per line")
    return tuple(map(str, found))


def _refused(text: str, expected: str) -> BadValue:
    return BadValue("sequence", _short(text), expected)


def _short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:39]}…"
