"""The command as users meet it: one line for a mistake, plain lines or JSON, names that do not change."""

import os
import pty
import subprocess
from contextlib import suppress

import forked
import pytest
from typed import in_process

ASKED = ("run", "flips", "--agent", "random", "--p", "0,0.4", "--trials", 4, "--repetitions", 2, "--no-report")


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "study"
    assert in_process(*ASKED, "--out", path).exit_code == 0
    return path


def test_plain_lines_say_what_is_played(lockprobe, directory, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "abc")  # of builds, and no number
    _, said, _ = lockprobe(*ASKED, "--out", directory)
    assert "Study flips on chain-4: 2 conditions: truth; flip?p=0.4; 2 repetitions of 4 trials of 20 steps" in said
    assert "agents random; seed 1; 16 trials in all\n" in said
    assert "16 of 16 trials are done already; 0 are owed" in said
    assert "\x1b" not in said
    assert lockprobe("status", directory)[::2] == (0, "")


def test_a_terminal_gets_a_live_table(tmp_path):
    ours, theirs = pty.openpty()
    process = forked.start(
        ["run", "flips", "--agent", "random", "--trials", 4, "--no-report", "--out", tmp_path],
        stdout=theirs, stderr=theirs, env=os.environ | {"TERM": "xterm", "COLUMNS": "120"},
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # when the other end is closed
        while part := os.read(ours, 65536):
            shown += part
    os.close(ours)
    assert process.wait() == 0
    assert all(said in shown for said in (b"84/84 trials", b"solved", b"steps/s"))


@pytest.mark.parametrize("group", [[], ["box"]])
def test_without_a_command_the_help_is_printed_line_by_line(lockprobe, group):
    status, said, error = lockprobe(*group)
    assert (status, said) == (2, "")
    assert error.split() == lockprobe(*group, "--help")[1].split()
    assert "\n  list " in error or "\n  run  " in error


def test_without_out_the_same_command_finds_its_directory_again(lockprobe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        said = lockprobe("run", "flips", "--agent", "round-robin", "--trials", 1, "--no-report")[1]
    assert "21 of 21 trials are done already" in said
    assert len(list((tmp_path / "lockprobe-runs").iterdir())) == 1


def test_a_closed_pipe_is_no_error(directory):
    reads, writes = os.pipe()
    os.close(reads)
    process = forked.start(["export", directory], stdout=writes, stderr=subprocess.PIPE)
    os.close(writes)
    assert process.communicate()[1] == ""
