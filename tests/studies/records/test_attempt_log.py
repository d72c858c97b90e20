"""Attempts on disk: what is read back, and what a crash or another hand leaves."""

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.running.paused_trial import RecordedAttempt

STEPS = [RecordedAttempt("A", None, "You attempted A.", "why"), RecordedAttempt("B", "moved", "", "\N{SNOWMAN}")]


def written(directory, key="k", steps=STEPS):
    with AttemptLog.open(directory) as log:
        log.begin(key)
        for step in steps:
            log.attempt(key, step)
    return directory / "attempts.jsonl"


def test_steps_are_read_back_by_trial(tmp_path):
    written(tmp_path)
    written(tmp_path, "other", STEPS[:1])
    with AttemptLog.open(tmp_path) as log:
        assert (log.attempts("k"), log.attempts("other")) == (tuple(STEPS), tuple(STEPS[:1]))
        assert (log.attempts("none"), log.under_way("none"), log.times_begun("none")) == ((), False, 0)
        log.begin("k")
        assert log.times_begun("k") == 2
    with AttemptLog.open(tmp_path) as log:
        assert log.times_begun("k") == 2


def test_a_box_that_broke_is_begun_from_the_first_step(tmp_path):
    written(tmp_path)
    with AttemptLog.open(tmp_path) as log:
        log.broke("k")
        assert (log.attempts("k"), log.under_way("k")) == ((), False)
    with AttemptLog.open(tmp_path) as log:
        assert (log.attempts("k"), log.under_way("k")) == ((), False)


def test_a_torn_last_line_never_happened(tmp_path):
    path = written(tmp_path)
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    for cut in range(1, len(lines[-1]) + 1):
        path.write_bytes(whole[: len(whole) - cut])
        with AttemptLog.open(tmp_path) as log:
            assert log.attempts("k") == tuple(STEPS[:1])
        assert path.read_bytes() == b"".join(lines[:-1])


@pytest.mark.parametrize(
    "line", [b"{}", b"[]", b"rubbish", b'{"key":"k","kind":"other"}', b'{"key":1,"kind":"begun"}', b"\xff"]
)
def test_a_damaged_line_is_named(tmp_path, line):
    path = written(tmp_path)
    path.write_bytes(path.read_bytes() + line + b"\n")
    with pytest.raises(BadFile, match="line 4: "), AttemptLog.open(tmp_path):
        pass
