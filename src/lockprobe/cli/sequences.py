"""Reads action sequences from a file or standard input, one per line."""

from __future__ import annotations

import re
import sys
from contextlib import nullcontext
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import LARGEST_INPUT
from lockprobe.statistics.loops.sequence_line import parse_sequence

MOST_ACTIONS = 64
"""The largest value of ``--actions``."""


def numbered_sequences(file: str) -> list[tuple[int, tuple[str, ...]]]:
    """Read the sequences in a file (``-``: standard input) with their line numbers.

    Empty lines are skipped, and their number is printed on standard error.
    """
    if not file:
        raise BadValue("file", file, "the name of a file, or - for standard input")
    try:
        with nullcontext(sys.stdin.buffer) if file == "-" else Path(file).open("rb") as source:
            content = source.read(LARGEST_INPUT + 1)  # a pipe is welcome here: cat FILE |, <(command)
        if len(content) > LARGEST_INPUT:
            raise BadFile(file, f"larger than {LARGEST_INPUT} bytes")
        lines = re.split(r"\r\n|\n|\r", content.decode("utf-8-sig"))
    except AttributeError:
        raise BadFile(file, "standard input is closed") from None
    except OSError as error:
        raise BadFile(file, f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadFile(file, "not text in UTF-8") from None
    if not lines[-1]:
        lines.pop()
    found = [(number, sequence) for number, line in enumerate(lines, 1) if (sequence := _parsed(file, number, line))]
    if empty := len(lines) - len(found):
        print(f"{count(empty, 'empty line')} skipped", file=sys.stderr)
    return found


def _parsed(file: str, number: int, line: str) -> tuple[str, ...]:
    try:
        return parse_sequence(line)
    except BadValue as error:
        raise BadFile(file, f"line {number}: {error}") from None


def read_sequences(file: str) -> list[tuple[str, ...]]:
    """Read the sequences in a file without line numbers."""
    return [sequence for _, sequence in numbered_sequences(file)]


def check_actions(file: str, where: str, seen: int, actions: int) -> None:
    """Refuse sequences with more distinct actions than ``--actions``."""
    if seen > MOST_ACTIONS:
        raise BadFile(file, f"{where}: {seen} distinct actions, at most {MOST_ACTIONS} are possible")
    if seen > actions:
        raise BadFile(file, f"{where}: {seen} distinct actions, but --actions is {actions}")
