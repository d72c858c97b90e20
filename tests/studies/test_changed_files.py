"""Who deletes or replaces the store of a study while it is written ends the writing in one line, and loses nothing."""

import asyncio
import shutil

import pytest
from builders import call_of, make_trial
from stored import unanswered

from lockprobe.foundation.errors import BadFile, DirectoryBusy
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load

STUDY = study(StudyOptions(agent=["random"], trials=3, repetitions=1, p=[0]))
TRIALS = [make_trial([0, 1], budget=2, trial=number) for number in (1, 2, 3)]


def append(journal, trial):
    journal.append(trial, 1)


def replaced(path):
    """An older state of a file takes its place, as cloud clients save."""
    shutil.copy(path, path.with_suffix(".new"))
    path.with_suffix(".new").replace(path)


def deleted(path):
    path.unlink()


def put_back(directory):
    for beside in ("-wal", "-shm"):
        (directory / f"study.db{beside}").unlink(missing_ok=True)
    (directory / "study.db.rescued").replace(directory / "study.db")


@pytest.mark.parametrize("change", [replaced, deleted])
def test_records_that_are_replaced_end_the_run_and_stand_whole_beside_it(tmp_path, change):
    with Journal.open(tmp_path, STUDY) as journal:
        append(journal, TRIALS[0])
        append(journal, TRIALS[1])
        change(tmp_path / "study.db")
        with pytest.raises(BadFile) as ended:
            append(journal, TRIALS[2])
        if change is replaced:
            with pytest.raises(DirectoryBusy), Journal.open(tmp_path, STUDY):
                pass
    assert str(ended.value) == (
        f"{tmp_path}/study.db: {change.__name__} by somebody else while it was being written (a cloud client?), so "
        "this ends here; all that was written is in study.db.rescued: put it in its place, and start again"
    )
    put_back(tmp_path)
    with Journal.open(tmp_path, STUDY) as journal:
        append(journal, TRIALS[2])
    assert load(tmp_path) == TRIALS


@pytest.mark.parametrize("change", [replaced, deleted])
def test_what_is_asked_is_not_asked_where_it_cannot_be_written_down(tmp_path, change):
    answered, call = call_of(TRIALS[1]), call_of(TRIALS[0], reply=None)
    with Journal.open(tmp_path, STUDY) as journal:
        page = journal.calls.of(next(STUDY.plans("random")))
        journal.calls.write(answered)
        change(tmp_path / "study.db")
        with pytest.raises(BadFile, match=f"study.db: {change.__name__} by somebody else"):
            asyncio.run(page.reserve(call))
    put_back(tmp_path)
    assert read_calls(tmp_path) == [answered]
    assert len(unanswered(tmp_path)) <= 1
