"""The names of files in the directory of a study, which say what a directory holds."""

from __future__ import annotations

SETTINGS = "study.json"
"""The settings of a study."""

PEOPLE_DIRECTORY = "people"
"""Holds the texts and settings with which people take part; what they do is in the store."""
