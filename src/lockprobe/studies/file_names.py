"""The names of files in the directory of a study, which say what a directory holds."""

from __future__ import annotations

SETTINGS = "study.json"
"""The settings of a study."""

PEOPLE_DIRECTORY = "people"
"""Holds a file of JSON lines for each participant. Who has joined plays the settings of the study there."""
