"""The names of the files in the directory of a study, which say what a directory holds."""

from __future__ import annotations

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


def not_here(name: str) -> str:
    """What to say of a directory without a file of a study."""
    return f"no {name} here; is it the directory of a study?"
