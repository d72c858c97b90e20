"""The command as users meet it: one line for a mistake, plain lines or JSON, names that do not change."""

import csv
import io
import json
import os
import pty
import subprocess
import sys

import forked
import pytest
from typed import typed


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "study"
    done = typed("run", "flips", "--agent", "random", "--agent", "human-inspired", "--p", "0,0.4", "--trials", 4,
                     "--repetitions", 2, "--seed", 3, "--no-report", "--out", path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return path


def test_plain_lines_say_what_is_played(directory):
    again = typed("run", "flips", "--agent", "random", "--agent", "human-inspired", "--p", "0,0.4", "--trials", 4,
                      "--repetitions", 2, "--seed", 3, "--no-report", "--out", directory)  # fmt: skip
    assert (
        "Study flips on chain-4: 2 conditions: truth; flip?p=0.4; 2 repetitions of 4 trials of 20 steps" in again.stdout
    )
    assert "32 of 32 trials are done already; 0 are owed" in again.stdout
    assert "\x1b" not in again.stdout


def test_a_terminal_gets_a_live_table(tmp_path):
    ours, theirs = pty.openpty()
    process = forked.start(
        ["run", "flips", "--agent", "random", "--trials", 50, "--no-report", "--out", tmp_path],
        stdout=theirs, stderr=theirs, env=os.environ | {"TERM": "xterm", "COLUMNS": "120"},
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert process.wait() == 0
    text = shown.decode()
    assert "1050/1050 trials" in text
    assert "solved" in text
    assert "steps/s" in text


def test_export_is_tidy(directory):
    rows = list(csv.DictReader(io.StringIO(typed("export", directory, "--format", "csv").stdout)))
    assert list(rows[0]) == [
        "key", "agent", "box", "modality", "condition", "p", "repetition", "trial", "step", "joint", "label", "moved",
        "told_moved", "claimed", "misread", "state", "target", "ending", "panel",
    ]  # fmt: skip
    lines = typed("export", directory, "--format", "jsonl").stdout.splitlines()
    assert len(lines) == len(rows)
    assert json.loads(lines[0])["step"] == 1


def test_what_cannot_be_written_is_one_line(directory, tmp_path):
    done = typed("export", directory, "--out", tmp_path / "no" / "steps.csv")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "cannot be written (No such file or directory)" in done.stderr
    (tmp_path / "full").symlink_to("/dev/full")
    done = typed("export", directory, "--out", tmp_path / "full")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["run", "flip"],
            "no study is called 'flip' (did you mean 'flips'?); there are: flips, modalities, why, looks, mechanisms.toml, FILE.toml",
        ),
        (["run", "flips", "--trials", "0"], "trials: got 0, expected a whole number from 1 to 1000000"),
        (["run", "none.toml"], "none.toml: cannot be read (No such file or directory)"),
        (["status", "nowhere"], "nowhere: no study.json here; is it the directory of a study?"),
        (["report", "nowhere"], "nowhere: no "),
        (["loops", "none.txt"], "none.txt: cannot be read (No such file or directory)"),
        (["fly"], "No such command 'fly'."),
        (
            ["box", "chain-4"],
            "No such command 'chain-4' of lockprobe box; there are check, list, show, view, generate",
        ),
        (["run", "flips", "--trials", "ten"], "Invalid value for '--trials': expected a whole number"),
        (["run", "flips", "--workers", "0"], "Invalid value for '--workers': expected at least 1"),
        (["run", "flips", "--budget", "x"], "Invalid value for '--budget': expected a number"),
        (["serve", "--port", "80000"], "Invalid value for '--port': expected at most 65535"),
    ],
)
def test_a_users_mistake_is_one_line_in_plain_words(lockprobe, tmp_path, monkeypatch, arguments, line):
    monkeypatch.chdir(tmp_path)
    status, said, error = lockprobe(*arguments)
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert error.startswith("lockprobe: " + line)


@pytest.mark.parametrize("group", [[], ["box"]])
def test_without_a_command_the_help_is_printed_line_by_line(group):
    done, asked = typed(*group), typed(*group, "--help")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.split() == asked.stdout.split()
    assert "\n  list " in done.stderr or "\n  run  " in done.stderr


def test_without_out_the_same_command_finds_its_directory_again(tmp_path):
    for _ in range(2):
        done = typed("run", "flips", "--agent", "round-robin", "--trials", 1, "--no-report", cwd=tmp_path)
    assert "21 of 21 trials are done already" in done.stdout
    assert len(list((tmp_path / "lockprobe-runs").iterdir())) == 1


def test_a_date_of_builds_that_is_no_number_ends_no_command(lockprobe, directory, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "abc")
    assert lockprobe("status", directory)[::2] == (0, "")


def test_a_closed_pipe_is_no_error(directory):
    done = subprocess.run(
        f"{sys.executable} -m lockprobe export {directory} | head -n 1", shell=True, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.stdout.startswith("key,agent")
    assert done.stderr == ""
