"""What anybody else does to the files of a study while it is written ends the writing in one line, and loses nothing."""

import asyncio
import os
import shutil
from contextlib import closing

import pytest
from builders import call_of, make_trial

from lockprobe.foundation.errors import BadFile, DirectoryBusy
from lockprobe.foundation.storage.jsonl import LineFile
from lockprobe.people.diary import DiaryFile, Did, Joined, read_diary
from lockprobe.people.responses import Next
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import ASKED, CALLS
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing

STUDY = study(StudyOptions(agent=["random"], trials=3, repetitions=1, p=[0]))
JOINED = Joined(identity="3f9a01bc", token="0" * 64, at=10.5, platform={}, slots=(), words="en 0")
TRIALS = [make_trial([0, 1], budget=2, trial=number) for number in (1, 2, 3)]


def append(journal, trial):
    journal.append(trial, Timing(key=trial.key, seconds=1, steps=len(trial.steps)))


def saved_by_an_editor(path):
    """An older state of a file takes its place, as editors and cloud clients save."""
    draft = path.with_suffix(".new")
    draft.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:1]))
    draft.replace(path)


def cut(path):
    os.truncate(path, 0)


def appended_to(path):
    with path.open("ab") as file:
        file.write(path.read_bytes())


def rewritten_to_the_same_size(path):
    content = path.read_bytes()
    path.write_bytes(content[:-9] + b"x" * 8 + b"\n")


def deleted(path):
    path.unlink()


@pytest.mark.parametrize("change", [saved_by_an_editor, deleted])
def test_records_that_are_replaced_end_the_run_and_stand_whole_beside_it(tmp_path, change):
    with Journal.open(tmp_path, STUDY) as journal:
        append(journal, TRIALS[0])
        append(journal, TRIALS[1])
        change(tmp_path / "trials.jsonl")
        with pytest.raises(BadFile) as ended:
            append(journal, TRIALS[2])
    what = "deleted" if change is deleted else "replaced"
    assert str(ended.value) == (
        f"{tmp_path}/trials.jsonl: {what} by somebody else while it was being written (an editor, a cloud client?), so "
        "this ends here; all that was written is in trials.jsonl.rescued: put it in its place, or append it to "
        "it, and start again"
    )
    (tmp_path / "trials.jsonl.rescued").replace(tmp_path / "trials.jsonl")
    assert load(tmp_path) == TRIALS


@pytest.mark.parametrize("change", [cut, appended_to, rewritten_to_the_same_size])
def test_records_that_are_changed_where_they_lie_end_the_run(tmp_path, change):
    path = tmp_path / "trials.jsonl"
    with Journal.open(tmp_path, STUDY) as journal:
        append(journal, TRIALS[0])
        change(path)
        changed = path.read_bytes()
        for trial in TRIALS[1:]:
            with pytest.raises(BadFile, match=r"changed by somebody.*still to be written is in trials.jsonl.rescued"):
                append(journal, trial)
    assert path.read_bytes() == changed
    path.write_bytes((tmp_path / "trials.jsonl.rescued").read_bytes())
    assert load(tmp_path) == TRIALS[1:]


@pytest.mark.parametrize("name", [CALLS, "timings.jsonl"])
def test_calls_and_clock_readings_too(tmp_path, name):
    call = call_of(TRIALS[1])
    with Journal.open(tmp_path, STUDY) as journal:
        journal.calls.write(call)
        append(journal, TRIALS[0])
        before = (tmp_path / name).read_bytes()
        saved_by_an_editor(tmp_path / name)
        with pytest.raises(BadFile, match=f"{name}: replaced by somebody else"):
            journal.calls.write(call) if name == CALLS else append(journal, TRIALS[1])
    assert (tmp_path / f"{name}.rescued").read_bytes().startswith(before)


def test_what_is_asked_is_not_asked_where_it_cannot_be_written_down(tmp_path):
    with Journal.open(tmp_path, STUDY) as journal:
        page, call = journal.calls.of(next(STUDY.plans("random"))), call_of(TRIALS[0], reply=None)
        asyncio.run(page.reserve(call))
        deleted(tmp_path / ASKED)
        with pytest.raises(BadFile, match=f"{ASKED}: deleted by somebody else"):
            asyncio.run(page.reserve(call))
    assert list(read_calls(tmp_path)) == []


def test_a_directory_that_is_deleted_does_not_come_back(tmp_path):
    with Journal.open(tmp_path / "d", STUDY) as journal:
        append(journal, TRIALS[0])
        shutil.rmtree(tmp_path / "d")
        with pytest.raises(BadFile, match=r"its directory was deleted or moved .* so this ends here$"):
            append(journal, TRIALS[1])
    assert list(tmp_path.iterdir()) == []


def test_the_directory_stays_locked_when_its_records_are_replaced(tmp_path):
    with Journal.open(tmp_path, STUDY) as journal:
        append(journal, TRIALS[0])
        saved_by_an_editor(tmp_path / "trials.jsonl")
        with pytest.raises(DirectoryBusy), Journal.open(tmp_path, STUDY):
            pass
    with Journal.open(tmp_path, STUDY) as journal:
        assert set(journal.trials) == {TRIALS[0].key}


@pytest.mark.parametrize("change", [cut, appended_to, saved_by_an_editor])
def test_an_act_is_not_done_where_somebody_else_has_changed_the_diary(tmp_path, change):
    act = Did(at=11.0, turn=2, scene="page", act=Next(), item="1")
    diary = DiaryFile(tmp_path / "people" / "3f9a01bc.jsonl")
    for line in JOINED, act:
        diary.write(line)
    change(diary.path)
    changed = diary.path.read_bytes()
    for _ in range(2):
        with pytest.raises(BadFile, match="by somebody else while it was being written"):
            diary.write(act.model_copy(update={"turn": 3}))
    assert [path.name for path in diary.path.parent.iterdir()] == [diary.path.name]
    assert diary.path.read_bytes() == changed
    diary.path.write_bytes(b"")
    again = DiaryFile(diary.path)
    again.write(JOINED)
    assert read_diary(diary.path) == [JOINED]


def test_a_second_rescue_gets_a_name_of_its_own(tmp_path):
    for name in ("lines.rescued", "lines.rescued-2"):
        with closing(LineFile(tmp_path / "lines")) as file:
            file.append(b"a")
            deleted(tmp_path / "lines")
            for _ in range(2):  # a line that is offered again stands there once
                with pytest.raises(BadFile, match=f"{name}: put"):
                    file.append(b"b")
        assert (tmp_path / name).read_bytes() == b"a\nb\n"


def test_who_withdraws_is_struck_from_what_was_rescued_too(tmp_path):
    people = study(StudyOptions(agent=["participant"], trials=3, repetitions=1, p=[0]))
    ann, bob = (
        make_trial([0, 1], budget=2, trial=n, agent=f"participant:{who}") for n, who in ((1, "aaaa"), (2, "bbbb"))
    )
    with Journal.open(tmp_path, people) as journal:
        append(journal, ann)
        append(journal, bob)
        saved_by_an_editor(tmp_path / "trials.jsonl")
        with pytest.raises(BadFile):
            append(journal, ann)
    with Journal.open(tmp_path, people) as journal:
        journal.delete_agent("participant:aaaa")
        assert b"aaaa" not in b"".join(path.read_bytes() for path in tmp_path.glob("trials*"))
        assert b"bbbb" in (tmp_path / "trials.jsonl.rescued").read_bytes()
        journal.delete_agent("participant:bbbb")
        assert not (tmp_path / "trials.jsonl.rescued").exists()
