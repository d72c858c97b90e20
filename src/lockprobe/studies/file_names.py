"""The names of the files in the directory of a study or of a suite, which say what a directory holds."""

from __future__ import annotations

from pathlib import Path

__all__ = [
    "ASKED",
    "ATTEMPTS",
    "CALLS",
    "PEOPLE_DIRECTORY",
    "RECORDS",
    "SCORES",
    "SETTINGS",
    "TIMINGS",
    "is_suite",
    "not_here",
]

SETTINGS = "study.json"
"""The settings of a study."""

RECORDS = "trials.jsonl"
"""Its finished trials, one a line."""

TIMINGS = "timings.jsonl"
"""How long they took."""

CALLS = "calls.jsonl"
"""The calls of providers."""

ASKED = "asked.jsonl"
"""The same calls before they are made, each with its maximum cost."""

ATTEMPTS = "attempts.jsonl"
"""Every attempt of a client with tools, before its report leaves; the server of clients writes it."""

PEOPLE_DIRECTORY = "people"
"""Holds a file of JSON lines for each participant. Who has joined plays the settings of the study there."""

SCORES = "suite.json"
"""The file of a suite's directory: which suite it is and, once trials have ended, its scores."""


def is_suite(directory: Path) -> bool:
    """Whether a directory is that of a suite."""
    return (directory / SCORES).is_file() and not (directory / SETTINGS).exists()


def not_here(directory: Path, name: str) -> str:
    """What to say of a directory without a file of a study: that it is no study, or which ones a suite has."""
    if is_suite(directory):
        studies = sorted(str(path.parent) for path in directory.glob(f"*/{SETTINGS}"))
        return f"a suite; its studies are {', '.join(studies) or 'not begun'}"
    return f"no {name} here; is it the directory of a study?"
