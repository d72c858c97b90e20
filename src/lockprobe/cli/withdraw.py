"""``lockprobe withdraw``: deletes all data of one participant."""

from __future__ import annotations

from typing import Annotated

import typer

from lockprobe.cli.command import Directory
from lockprobe.foundation.errors import BadValue
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import Experiment, kept_experiment
from lockprobe.people.withdrawal import delete_unnamed_pictures
from lockprobe.people.withdrawal import withdraw as delete_all
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal

Participant = Annotated[
    str, typer.Argument(metavar="PARTICIPANT", help="The participant: the ID in the study, or a platform's ID.")
]


def withdraw(directory: Directory, participant: Participant) -> None:
    """Delete all data of a participant: diary, records, times and pictures.

    The number of withdrawals stays, and a keyed digest of a platform's ID, with which nobody can begin again.

    No server may be running on the directory. Reports and exports written before have to be written again.
    """
    study, joined = read_study(directory), [diary.joined for diary in read_diaries(directory)]
    found = [one for one in joined if participant in (one.identity, *one.platform.values())]
    if len(found) != 1:
        raise BadValue("participant", participant, f"the ID of one participant ({len(found)} people have this one)")
    names = (kept_experiment(directory) or Experiment()).recruitment
    with Journal.open(directory, study) as journal:
        delete_all(journal, found[0].identity, found[0].platform.get(next(iter(names), ""), ""))
        delete_unnamed_pictures(journal)
    print(f"Withdrawn. Reports and exports of {directory} written before still count this person: write them again.")
