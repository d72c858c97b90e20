"""Action sequences from a file or from standard input, one a line."""

from __future__ import annotations

import sys
from pathlib import Path

from lockprobe.analysis.loops import parse_sequence
from lockprobe.errors import BadFile

__all__ = ["read_sequences"]


def read_sequences(file: str) -> list[tuple[str, ...]]:
    """The sequences in a file (``-``: standard input) without empty lines."""
    try:
        content = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
        lines = content.decode("utf-8-sig").splitlines()
    except AttributeError:
        raise BadFile(file, "standard input is closed") from None
    except OSError as error:
        raise BadFile(file, f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadFile(file, "not text in UTF-8") from None
    return [sequence for line in lines if (sequence := parse_sequence(line))]
