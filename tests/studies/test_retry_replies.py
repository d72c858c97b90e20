"""Trials that ended at an unusable reply are owed anew where somebody asks: nothing is lost, and no old call is used."""

import re
from dataclasses import replace

import pytest
from builders import make_trial

from lockprobe.call import Call
from lockprobe.errors import BadValue
from lockprobe.studies.call_log import read_calls
from lockprobe.studies.journal import Journal, Timing, left_out, load
from lockprobe.studies.retry_replies import owe_anew
from lockprobe.studies.spending import Ledger
from lockprobe.studies.study_options import StudyOptions
from lockprobe.studies.studyfile import study

STUDY = study(StudyOptions(agent=["random"], trials=3, p=[0], repetitions=1, max_steps=2))
UNUSABLE, BROKEN, SOLVED = (
    make_trial([0], budget=2, broken="reply"),
    make_trial([0], budget=2, broken="model", trial=2),
    make_trial([0, 0], budget=2, trial=3),
)


def written(directory):
    call = Call(key=UNUSABLE.key, step=1, turn=1, request="r", reply="nonsense")
    with Journal.open(directory, STUDY) as journal:
        journal.calls.write(call)
        for trial in (UNUSABLE, BROKEN, SOLVED):
            journal.append(trial, Timing(key=trial.key, seconds=3.0, steps=1))
    return call


def test_only_what_ended_at_a_reply_is_owed_anew_and_stays_so_however_often_the_run_is_broken_off(tmp_path):
    written(tmp_path)
    with Journal.open(tmp_path, STUDY) as journal:
        assert [journal.owes(trial.key) for trial in (UNUSABLE, BROKEN, SOLVED)] == [False, True, False]
        assert owe_anew(journal, STUDY, "reply") == 1
        assert [journal.owes(trial.key) for trial in (UNUSABLE, BROKEN, SOLVED)] == [True, True, False]
        assert owe_anew(journal, STUDY, "reply") == 0
    with Journal.open(tmp_path, STUDY) as journal:
        assert journal.owes(UNUSABLE.key)


def test_the_earlier_record_stays_and_the_new_one_says_that_it_is_a_replay(tmp_path):
    written(tmp_path)
    before = (tmp_path / "trials.jsonl").read_bytes()
    with Journal.open(tmp_path, STUDY) as journal:
        owe_anew(journal, STUDY, "reply")
        journal.append(make_trial([0], budget=2, broken="model"), Timing(key=UNUSABLE.key, seconds=1.0, steps=1))
        journal.append(make_trial([0, 0], budget=2), Timing(key=UNUSABLE.key, seconds=1.0, steps=2))
    assert (tmp_path / "trials.jsonl").read_bytes().startswith(before)
    found = {trial.key: trial for trial in load(tmp_path)}
    assert (found[UNUSABLE.key].ending, found[UNUSABLE.key].replays) == ("budget", 1)
    assert found[SOLVED.key] == SOLVED
    assert (left_out(tmp_path).replaced, left_out(tmp_path).repeated) == (2, 0)


def test_the_new_trial_makes_calls_of_its_own_and_those_of_the_old_one_count_as_spent(tmp_path):
    call = written(tmp_path)
    with Journal.open(tmp_path, STUDY) as journal:
        owe_anew(journal, STUDY, "reply")
        assert journal.calls.recall(UNUSABLE.key, 1, 1, "r") is None
        journal.append(make_trial([0], budget=2, broken="model"), Timing(key=UNUSABLE.key, seconds=1.0, steps=1))
    with Journal.open(tmp_path, STUDY) as journal:  # the replay was broken off
        assert journal.calls.recall(UNUSABLE.key, 1, 1, "r") is None
        journal.calls.write(replace(call, reply="usable"))
    with Journal.open(tmp_path, STUDY) as journal:
        assert journal.calls.recall(UNUSABLE.key, 1, 1, "r").reply == "usable"
    spent = Ledger(STUDY, read_calls(tmp_path)).total
    assert (spent.usage.calls, spent.failed, spent.broken_off) == (2, 0, 0)


def test_records_without_replays_are_written_as_ever(tmp_path):
    written(tmp_path)
    assert not {b"replays", b"again"} & {*re.findall(rb"\w+", (tmp_path / "trials.jsonl").read_bytes())}


def test_another_boundary_is_refused(tmp_path):
    with (
        Journal.open(tmp_path, STUDY) as journal,
        pytest.raises(BadValue, match="expected reply; what broke elsewhere"),
    ):
        owe_anew(journal, STUDY, "model")
