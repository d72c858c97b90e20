"""Trials whose error is final are owed anew where somebody asks for it: ``lockprobe run … --again reply``.

An agent that never gave a usable reply is a finding, so its trial is final. Where the fault was in the set-up, a server
that left a field out for example, the trial can be played anew. Nothing is lost: the record stays in the file, a copy
of it that says "again" follows, and the record of the new trial counts how often it was played anew. The new trial
makes calls of its own; those of the old one stay on disk and count as spent.
"""

from __future__ import annotations

from dataclasses import replace

from lockprobe.call import OWED_ANEW, Call
from lockprobe.errors import BadValue
from lockprobe.spec import PEOPLE
from lockprobe.studies.call_log import read_calls
from lockprobe.studies.journal import Journal, Timing, load, read_timings
from lockprobe.studies.study import Study

__all__ = ["owe_anew"]


def owe_anew(journal: Journal, study: Study, boundary: str) -> int:
    """Have every trial of a study played anew that ended at a boundary for good.

    Args:
        journal: The open journal of the study.
        study: The study; people's trials are left alone.
        boundary: ``reply``, the only one whose errors are final.

    Returns:
        How many trials those are.

    Raises:
        BadValue: If there is no such boundary, or its errors are owed anyhow.
        BadFile: If it cannot be written.
    """
    if boundary != "reply":
        raise BadValue("again", boundary, "reply; what broke elsewhere is owed without being asked for")
    readings = {reading.key: reading for reading in read_timings(journal.directory)}
    asked = {call.key for call in read_calls(journal.directory)}
    found = 0
    for trial in load(journal.directory):
        error = trial.error
        if error is None or trial.owed_again or trial.group == PEOPLE or not study.asks_for(trial):
            continue
        if trial.key in asked:
            nothing = Call(key=trial.key, step=0, turn=0, request="", reply=None, error=OWED_ANEW)
            journal.calls.write(nothing)
        reading = readings.get(trial.key, Timing(key=trial.key, seconds=0.0, steps=0))
        journal.append(replace(trial, error=replace(error, again=True)), reading)
        found += 1
    return found
