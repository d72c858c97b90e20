"""Action sequences from a file or from standard input, one a line."""

from __future__ import annotations

import sys
from pathlib import Path

from lockprobe.analysis.loops import parse_sequence
from lockprobe.errors import BadFile

__all__ = ["numbered_sequences", "read_sequences"]


def numbered_sequences(file: str) -> list[tuple[int, tuple[str, ...]]]:
    """The sequences in a file (``-``: standard input) with their line numbers.

    Empty lines hold none; they are counted in a line on standard error.
    """
    try:
        content = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
        lines = content.decode("utf-8-sig").splitlines()
    except AttributeError:
        raise BadFile(file, "standard input is closed") from None
    except OSError as error:
        raise BadFile(file, f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadFile(file, "not text in UTF-8") from None
    found = [(number, sequence) for number, line in enumerate(lines, 1) if (sequence := parse_sequence(line))]
    if empty := len(lines) - len(found):
        print(f"{empty} empty line{'s' * (empty > 1)} left out", file=sys.stderr)
    return found


def read_sequences(file: str) -> list[tuple[str, ...]]:
    """The same without numbers."""
    return [sequence for _, sequence in numbered_sequences(file)]
