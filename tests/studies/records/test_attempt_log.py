"""Attempts on disk: what is read back, and what a kill or another hand leaves."""

from contextlib import contextmanager

import pytest
from stored import contents, sql

from lockprobe.foundation.storage.database import Damaged
from lockprobe.studies.records import store
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.running.paused_trial import RecordedAttempt

STEPS = [RecordedAttempt("A", None, "You attempted A.", "why"), RecordedAttempt("B", "moved", "", "\N{SNOWMAN}")]


@contextmanager
def log_in(directory):
    with store.written(directory) as opened:
        yield AttemptLog(opened)


def written(directory, key="k", steps=STEPS):
    with log_in(directory) as log:
        log.begin(key)
        for number, step in enumerate(steps, 1):
            log.attempt(key, step)
            assert AttemptLog.read(directory)[key] == tuple(steps[:number])  # before its report leaves


def test_steps_are_read_back_by_trial(tmp_path):
    written(tmp_path)
    written(tmp_path, "other", STEPS[:1])
    with log_in(tmp_path) as log:
        assert (log.attempts("k"), log.attempts("other")) == (tuple(STEPS), tuple(STEPS[:1]))
        assert (log.attempts("none"), log.under_way("none"), log.times_begun("none")) == ((), False, 0)
        log.begin("k")
        assert log.times_begun("k") == 2
    with log_in(tmp_path) as log:
        assert log.times_begun("k") == 2


@pytest.mark.parametrize(
    "entry", ["{}", "[]", "rubbish", '{"kind":"other"}', '{"kind":"begun","key":"k"}', '"\\ud800"']
)
def test_a_damaged_entry_is_named_and_nothing_is_overwritten(tmp_path, entry):
    written(tmp_path)
    sql(tmp_path, "insert into attempt values (null, 'k', ?1, checksum('k', ?1))", entry)
    before = contents(tmp_path)
    for use in (log_in, AttemptLog.read):
        with pytest.raises(Damaged, match=r"study.db: attempt 4, k: .*lockprobe import"), use(tmp_path):
            pass
    assert contents(tmp_path) == before
