"""The records of one agent are struck, and what stays is what stood there."""

from contextlib import closing
from dataclasses import replace

import pytest
from builders import make_trial, small_study

from lockprobe.errors import BadFile, DirectoryBusy
from lockprobe.spec import group_of
from lockprobe.storage.jsonl import LineFile
from lockprobe.studies.delete_records import rewritten, without
from lockprobe.studies.journal import Journal, Timing, load, read_timings

STUDY = small_study(["participant"], trials=3)
ANN, BOB = "participant:aaaa", "participant:bbbb"


def journal_of(directory, *trials):
    with Journal.open(directory, STUDY) as journal:
        for seconds, trial in enumerate(trials, 1):
            journal.append(trial, Timing(key=trial.key, seconds=float(seconds), steps=len(trial.steps)))
    return directory


def trial(agent, number, **more):
    """One of people's trials: its key is the same whoever plays it."""
    made = make_trial([0, 1, 2], agent=agent, trial=number, budget=3, **more)
    return replace(made, key=made.key.replace(agent, group_of(agent)))


def test_what_stays_stands_there_as_it_did(tmp_path):
    kept = [trial(BOB, 2), trial("random", 1)]
    journal_of(tmp_path, trial(ANN, 1), *kept, trial(ANN, 3))
    before = (tmp_path / "trials.jsonl").read_bytes().splitlines(keepends=True)
    with Journal.open(tmp_path, STUDY) as journal:
        journal.strike(ANN)
        assert [one.agent for one in journal.trials.values()] == [BOB, "random"]
        assert journal.owes(trial(ANN, 1).key)
        journal.append(trial(BOB, 3), Timing(key=trial(BOB, 3).key, seconds=9.0, steps=3))
    assert (tmp_path / "trials.jsonl").read_bytes().splitlines(keepends=True)[:2] == before[1:3]
    assert load(tmp_path) == [*kept, trial(BOB, 3)]
    assert [timing.seconds for timing in read_timings(tmp_path)] == [2.0, 3.0, 9.0]


def test_a_trial_that_broke_and_was_played_by_somebody_else_stays_theirs(tmp_path):
    journal_of(tmp_path, trial(ANN, 1, broken="plant"), trial(ANN, 2), trial(BOB, 1))
    with Journal.open(tmp_path, STUDY) as journal:
        journal.strike(ANN)
        assert not journal.owes(trial(BOB, 1).key)
    assert load(tmp_path) == [trial(BOB, 1)]
    assert [(timing.key, timing.seconds) for timing in read_timings(tmp_path)] == [(trial(BOB, 1).key, 3.0)]
    assert (tmp_path / "timings.jsonl").read_text().count("\n") == 1


def test_clock_readings_that_are_damaged_are_nobodys(tmp_path):
    journal_of(tmp_path, trial(ANN, 1))
    with (tmp_path / "timings.jsonl").open("a") as file:
        file.write("{]\n[1]\n")
    keys, timings, records = without(tmp_path, ANN)
    assert (keys, list(timings), list(records)) == ({trial(ANN, 1).key}, [b"{]\n", b"[1]\n"], [])


def test_the_directory_stays_locked(tmp_path):
    journal_of(tmp_path, trial(ANN, 1))
    with Journal.open(tmp_path, STUDY) as journal:
        journal.strike(ANN)
        with pytest.raises(DirectoryBusy), Journal.open(tmp_path, STUDY):
            pass
    with Journal.open(tmp_path, STUDY):
        pass


def test_what_cannot_be_written_leaves_all_as_it_was(tmp_path):
    path = tmp_path / "lines.jsonl"
    path.write_bytes(b"a\nb\n")
    with closing(LineFile(path)) as old:
        (tmp_path / ".lines.jsonl.draft").mkdir()
        with pytest.raises(BadFile):
            rewritten(old, [b"a\n"])
        old.append(b"c")
    assert path.read_bytes() == b"a\nb\nc\n"


def test_what_a_killed_draft_left_is_not_taken_along(tmp_path):
    path = tmp_path / "lines.jsonl"
    path.write_bytes(b"a\nb\n")
    (tmp_path / ".lines.jsonl.draft").write_bytes(b"torn")
    with closing(rewritten(LineFile(path), [b"b\n"])) as new:
        new.append(b"c")
    assert path.read_bytes() == b"b\nc\n"
    assert not (tmp_path / ".lines.jsonl.draft").exists()


@pytest.mark.parametrize(("agent", "stays"), [(ANN, 1.0), (BOB, 2.0)])
def test_of_a_trial_that_two_have_played_the_reading_of_the_other_stays(tmp_path, agent, stays):
    journal_of(tmp_path, trial(BOB, 1, broken="plant"), trial(ANN, 1))
    with Journal.open(tmp_path, STUDY) as journal:
        journal.strike(agent)
    assert [timing.seconds for timing in read_timings(tmp_path)] == [stays]


def test_a_reading_of_which_it_cannot_be_told_whose_it_is_goes(tmp_path):
    journal_of(tmp_path, trial(BOB, 1, broken="plant"), trial(ANN, 1), trial(BOB, 2))
    path = tmp_path / "timings.jsonl"
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[1:]))
    with Journal.open(tmp_path, STUDY) as journal:
        journal.strike(ANN)
    assert [timing.seconds for timing in read_timings(tmp_path)] == [3.0]
