"""What an experimenter is told when people can come: addresses to paste, places, and what is still to be done."""

from __future__ import annotations

from pathlib import Path

from lockprobe.people.capacity import what_each_plays
from lockprobe.people.consent import CODE
from lockprobe.people.experiment import Experiment
from lockprobe.people.texts import LANGUAGES, Words, read_words
from lockprobe.studies.study import Study

__all__ = ["reminders", "study_url", "told_at_the_start"]

PLACEHOLDERS = {
    **{name: "{{%" + name + "%}}" for name in ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")},
    "survey_code": "%SURVEY_CODE%",
    "workerId": "${workerId}",
    "assignmentId": "${assignmentId}",
    "hitId": "${hitId}",
}
"""What recruitment platforms fill in, by the parameter that holds it: Prolific, SONA, MTurk."""


def study_url(url: str, experiment: Experiment) -> str:
    """The address to paste into the recruitment platform, with its placeholders and the code with which one joins."""
    parts = [f"{name}={PLACEHOLDERS.get(name, '…')}" for name in experiment.recruitment]
    if experiment.join_code:
        parts.append(f"{CODE}={experiment.join_code}")
    return url + ("?" + "&".join(parts) if parts else "")


def reminders(words: Words, experiment: Experiment) -> tuple[str, ...]:
    """What is still to be done before people come."""
    found = []
    if any(words.consent == read_words(language).consent for language in LANGUAGES):
        found.append(
            "The consent text is the one that ships: it names nobody who is responsible. "
            "Edit a copy (lockprobe serve --write-texts mine.toml) and give --texts mine.toml."
        )
    if not (experiment.join_code or experiment.require_id):
        found.append(
            f"Whoever has the address can join, {experiment.joins_per_minute} a minute from one address "
            "(joins_per_minute; a class behind one router is let in). "
            "--require-id or --join-code CODE keep others out."
        )
    return tuple(found)


def told_at_the_start(
    study: Study, experiment: Experiment, words: Words, url: str, admin_url: str, directory: Path
) -> tuple[str, ...]:
    """The lines that are printed when people can come."""
    size = study.size // len(study.agents)
    own, given = url.rstrip("/") + "/", study_url(url, experiment)
    return (
        f"{study.name} on {study.box.name} for people: {size} trials, each played by one of them",
        *what_each_plays(study, experiment),
        f"Participants  {own}",
        *([f"To paste      {given}  (placeholders of the recruitment platform)"] if given != own else []),
        f"Admin         {admin_url}",
        f"Kept in       {directory}",
        *(f"Note          {line}" for line in reminders(words, experiment)),
        "Ctrl-C ends; the same command goes on.",
    )
