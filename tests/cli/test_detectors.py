"""``lockprobe detectors``, as typed."""

import json
from functools import partial

import pytest
from typed import in_process

from lockprobe.foundation.errors import BadFile
from lockprobe.statistics.loops.detectors import DETECTORS, as_table, comparison

NAMES = [detector.name for detector in DETECTORS]

ask = partial(in_process, "detectors")


def test_the_table():
    done = ask("--trials", 20, "--seed", 4)
    assert (done.stdout, done.stderr) == (as_table(comparison(20, 4)) + "\n", "")
    assert "µs" in ask("--trials", 20, "--clock").stdout.splitlines()[0]


def test_the_table_as_json():
    plain = [json.loads(line) for line in ask("--trials", 20, "--json").stdout.splitlines()]
    timed = [json.loads(line) for line in ask("--trials", 20, "--json", "--clock").stdout.splitlines()]
    assert [row["detector"] for row in plain] == NAMES
    for row, other in zip(plain, timed, strict=True):
        assert other.pop("microseconds") >= 0
        assert row == other


def test_which_detectors_flag_a_sequence(tmp_path):
    text = "ABCABDDCBADBDACCDBAC\n\nD D D D D\nABCDABCDABCDABCDABCD\n"
    lines = ask("-", stdin=text).stdout.splitlines()
    assert lines[0] == "20 actions: none"
    assert lines[1].startswith("5 actions: goose-like, gemini-cli-like")
    (tmp_path / "trials.txt").write_text(text)
    rows = [json.loads(line) for line in ask(tmp_path / "trials.txt", "--json").stdout.splitlines()]
    assert [row["n"] for row in rows] == [20, 5, 20]
    assert (rows[2]["scores"]["coverage"], rows[2]["scores"]["lz76"]) == (1.0, 4.0)
    assert {"any-loop", "coverage", "lz76", "compression"} <= set(rows[2]["flagged"])
    assert [set(row["scores"]) for row in rows] == [set(NAMES) - {"openhands-like"}] * 3


def test_what_cannot_be_judged_is_refused(tmp_path):
    with pytest.raises(BadFile, match="-: line 3: 5 distinct actions, but --actions is 4"):
        ask("-", stdin="ABCD\n\nABCDE")
    with pytest.raises(BadFile, match="-: line 1: 70 distinct actions, at most 64 are possible"):
        ask("-", stdin=" ".join(map(str, range(70))))
    assert ask("-", "--actions", 5, stdin="ABCDE").stdout == "5 actions: none\n"
    with pytest.raises(BadFile, match="cannot be read"):
        ask(tmp_path / "none.txt")
    assert ask("--trials", 3).exit_code == 2
