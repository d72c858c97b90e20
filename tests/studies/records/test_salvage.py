"""Attempts on disk, and what is sound of a damaged study is saved, and nothing else."""

import asyncio
import random
import shutil
from collections import Counter
from contextlib import contextmanager, suppress

import pytest
from builders import call_of, make_trial, small_study
from stored import contents, sql
from stored import written as opened
from taking_part import take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.database import Damaged
from lockprobe.people.diary import read_diaries
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import save_sound_rows
from lockprobe.studies.records.read_records import load, miscounted, replaced_records, rows_and_records
from lockprobe.studies.records.store import read
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.trial.trial_json import trial_to_json

STUDY = small_study(["random", "participant"], p=[0.0, 0.4], repetitions=1, trials=24)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A study with trials, of which one was played again, calls, attempts and acts, and all that it says."""
    directory = tmp_path_factory.mktemp("whole") / "S"
    for trial, person in (1, "aaaa01"), (2, "bbbb02"):
        take_part(directory, STUDY, person, [(0.4, 1, trial), (0.0, 1, trial)])
    luck = random.Random(1)
    with Journal.open(directory, STUDY) as journal:
        log = AttemptLog(journal.store)
        for number in range(1, 25):
            joints = [luck.randrange(3) for _ in range(20)]
            for broken in ["model"] * (number == 3) + [None]:
                trial = make_trial([] if broken else joints, trial=number, broken=broken)
                journal.append(trial, 1.5)
            asyncio.run(journal.calls.write(call_of(trial, reply=f"{joints} " * 9)))
            log.write(f"k{number % 5}", "attempt", RecordedAttempt("A", None, f"You attempted {joints}.", "why"))
    return (
        directory,
        everything(directory),
        {trial_to_json(one) for one in (*load(directory), *replaced_records(directory))},
    )


def everything(directory):
    """All that can be read of a directory, and how often it is there."""
    found = Counter(map(repr, [*map(trial_to_json, load(directory)), *read_calls(directory)]))
    for key, attempts in AttemptLog.read(directory).items():
        found.update(f"{key}: {attempt}" for attempt in attempts)
    for diary in read_diaries(directory):
        found.update(f"{diary.identity}: {line}" for line in (diary.joined, *diary.lines))
    return found


def test_of_a_sound_study_all_is_saved(whole, tmp_path):
    (tmp_path / "saved").mkdir()
    assert save_sound_rows(whole[0], tmp_path / "saved") == len(load(whole[0])) == 28
    saved, there = contents(tmp_path / "saved"), contents(whole[0])
    assert sorted(map(repr, saved.pop("study.db"))) == sorted(map(repr, there.pop("study.db")))
    assert saved == there


@pytest.mark.parametrize("seed", range(4))
def test_of_a_damaged_study_what_is_sound_is_saved(whole, tmp_path, seed):
    """Some bytes are others, or a page is lost; where it does not hold the way to others, few rows go with it."""
    directory, luck = shutil.copytree(whole[0], tmp_path / "S"), random.Random(seed)
    content, size = bytearray((directory / "study.db").read_bytes()), 4096
    pages = {luck.randrange(len(content) // size) for _ in range(luck.choice([1, 1, 3, 9]))}
    for first in (size * page for page in pages):
        if len(pages) == 1 and luck.random() < 0.5:
            content[first : first + size] = luck.choice([bytes(size), luck.randbytes(size)])
        else:
            content[first + luck.randrange(size)] ^= luck.randrange(1, 256)
    (directory / "study.db").write_bytes(content)
    with suppress(BadFile if 0 in pages else Damaged):
        everything(directory)
    (tmp_path / "saved").mkdir()
    try:
        save_sound_rows(directory, tmp_path / "saved")
    except BadFile:
        assert 0 in pages  # what SQLite has to read first
        return
    saved, (_, true, trials) = everything(tmp_path / "saved"), whole
    assert {*map(trial_to_json, load(tmp_path / "saved"))} <= trials
    assert saved <= true
    roots = {page - 1 for page in sql(whole[0], "select rootpage from sqlite_master where type = 'table'")}
    assert pages & roots or (true - saved).total() <= 24 * len(pages)
    with read(tmp_path / "saved") as store:
        assert [*miscounted(store), *(said for *_, said in rows_and_records(store) if said)] == []
    assert (directory / "study.db").read_bytes() == content


STEPS = [RecordedAttempt("A", None, "You attempted A.", "why"), RecordedAttempt("B", "moved", "", "\N{SNOWMAN}")]


@contextmanager
def log_in(directory):
    with opened(directory) as store:
        yield AttemptLog(store)


def written(directory, key="k", steps=STEPS):
    with log_in(directory) as log:
        log.write(key, "begun")
        for number, step in enumerate(steps, 1):
            log.write(key, "attempt", step)
            assert AttemptLog.read(directory)[key] == steps[:number]  # before its report leaves


def test_steps_are_read_back_by_trial(tmp_path):
    written(tmp_path)
    written(tmp_path, "other", STEPS[:1])
    with log_in(tmp_path) as log:
        assert log.attempts == {"k": STEPS, "other": STEPS[:1]}
        log.write("k", "begun")
        assert log.times_begun["k"] == 2
    with log_in(tmp_path) as log:
        assert log.times_begun["k"] == 2


def test_a_damaged_row_is_named_and_nothing_is_overwritten(tmp_path):
    written(tmp_path)
    sql(tmp_path, "update attempt set told = 'You attempted B.' where id = 2")
    before = contents(tmp_path)
    for use in (log_in, AttemptLog.read):
        with pytest.raises(Damaged, match=r"study.db: attempt 2, k: .*lockprobe import"), use(tmp_path):
            pass
    assert contents(tmp_path) == before
