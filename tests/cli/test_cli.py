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

COMMANDS = ["run", "status", "report", "export", "replay", "loops", "chance", "power", "box",
            "list", "doctor"]  # fmt: skip


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "study"
    done = typed("run", "flips", "--agent", "random", "--agent", "human-inspired", "--p", "0,0.4", "--trials", 4,
                     "--repetitions", 2, "--seed", 3, "--out", path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert f"Report: {path}/report.html" in done.stdout.splitlines()
    return path


def test_plain_lines_say_what_is_played(directory):
    again = typed("run", "flips", "--agent", "random", "--agent", "human-inspired", "--p", "0,0.4", "--trials", 4,
                      "--repetitions", 2, "--seed", 3, "--no-report", "--out", directory)  # fmt: skip
    assert "Flip study on chain-4: flip rate 0, 0.4; 2 repetitions of 4 trials of 20 steps" in again.stdout
    assert "32 of 32 trials are done already; 0 are owed" in again.stdout
    assert "\x1b" not in again.stdout


def test_json_lines(tmp_path):
    done = typed("run", "flips", "--agent", "random", "--p", "0", "--trials", 2, "--repetitions", 1,
                     "--out", tmp_path, "--json")  # fmt: skip
    events = [json.loads(line) for line in done.stdout.splitlines()]
    assert [event["event"] for event in events] == ["begin", "agent", "trial", "trial", "report"]
    assert events[-1]["path"] == str(tmp_path / "report.html")


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


def test_status(directory):
    facts = json.loads(typed("status", directory, "--json").stdout)
    assert (facts["trials"], facts["done"], facts["owed"], facts["errors"]) == (32, 32, 0, {})
    assert "32 of 32 done" in typed("status", directory).stdout


def test_export_is_tidy(directory):
    rows = list(csv.DictReader(io.StringIO(typed("export", directory, "--format", "csv").stdout)))
    assert list(rows[0]) == [
        "key", "agent", "box", "modality", "p", "repetition", "trial", "step", "joint", "moved", "told_moved",
        "claimed", "state", "target", "ending",
    ]  # fmt: skip
    lines = typed("export", directory, "--format", "jsonl").stdout.splitlines()
    assert len(lines) == len(rows)
    assert json.loads(lines[0])["step"] == 1


def test_replay(directory):
    text = typed("replay", directory, "flips/human-inspired/truth/rep=1/trial=1").stdout
    assert text.startswith("flips/human-inspired/truth/rep=1/trial=1: solved after ")
    steps = typed("replay", directory, "human-inspired/flip?p=0.4/rep=2/trial=3", "--json").stdout.splitlines()
    assert json.loads(steps[0])["step"] == 1


def test_what_cannot_be_written_is_one_line(directory, tmp_path):
    done = typed("export", directory, "--out", tmp_path / "no" / "steps.csv")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "cannot be written (No such file or directory)" in done.stderr
    (tmp_path / "full").symlink_to("/dev/full")
    done = typed("export", directory, "--out", tmp_path / "full")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


def test_chance():
    found = json.loads(typed("chance", "--length", 20, "--actions", 4, "--json").stdout)
    assert found["method"] == "exact"
    assert found["probability"] == pytest.approx(1 - 219018772080 / 4**20)


def test_box_show():
    facts = json.loads(typed("box", "show", "chain-4", "--json").stdout)
    assert (facts["optimum"], facts["target"], facts["initial"]) == (4, "revolute-left", "0000")
    assert facts["random_success"] == pytest.approx(0.392655, abs=1e-6)
    assert facts["interlock"]["slider-1"] == [{"slider-2": 1}]


def test_help_names_every_command():
    text = typed("--help").stdout
    assert all(command in text for command in COMMANDS)


def test_lists():
    assert "human-inspired" in typed("list", "agents").stdout
    assert "force_noise" in typed("list", "plants").stdout
    assert "llm:gguf:PATH" in typed("list", "models").stdout


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["run", "flip"],
            "no study is called 'flip' (did you mean 'flips'?); there are: flips, modalities, why, looks, mechanisms.toml, FILE.toml",
        ),
        (
            ["run", "flips", "--agent", "rando"],
            "no agent is called 'rando' (did you mean 'random'?); there are: random",
        ),
        (
            ["run", "flips", "--box", "chain-9"],
            "no box is called 'chain-9' (did you mean 'chain-8'?); there are: chain-2",
        ),
        (["run", "flips", "--p", "2"], "flip rate p: got 2.0, expected a number from 0 to 1"),
        (["run", "flips", "--p", "x"], "p: got 'x', expected numbers from 0 to 1 with commas between"),
        (
            ["run", "flips", "--flip", "often"],
            "flip: got 'often', expected one of transient, sticky, outcome-only, memoryless",
        ),
        (["run", "flips", "--trials", "0"], "trials: got 0, expected a whole number from 1 to 1000000"),
        (["run", "flips", "--trials", "ten"], "Invalid value for '--trials'"),
        (["run", "none.toml"], "none.toml: cannot be read (No such file or directory)"),
        (["run", "flips", "--agent", "llm:gguf:none.gguf"], "none.gguf: cannot be read (No such file or directory)"),
        (["status", "nowhere"], "nowhere: no study.json here; is it the directory of a study?"),
        (["verify", "nowhere"], "nowhere: no study.json here; is it the directory of a study?"),
        (["box", "generate", "--joints", "0"], "joints of random: got 0, expected one of 2, 3, 4, 5, 6, 7, 8"),
        (["report", "nowhere"], "nowhere: no "),
        (["loops", "none.txt"], "none.txt: cannot be read (No such file or directory)"),
        (["fly"], "No such command 'fly'."),
        (
            ["box", "chain-4"],
            "No such command 'chain-4' of lockprobe box; there are check, list, show, solve, generate",
        ),
    ],
)
def test_a_users_mistake_is_one_line_without_a_traceback(tmp_path, arguments, line):
    done = typed(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("lockprobe: " + line)


@pytest.mark.parametrize("group", [[], ["box"]])
def test_without_a_command_the_help_is_printed_line_by_line(group):
    done, asked = typed(*group), typed(*group, "--help")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.split() == asked.stdout.split()
    assert "\n  list " in done.stderr or "\n  run  " in done.stderr


def test_the_settings_of_another_study_are_refused_with_both_ways_out(directory):
    done = typed("run", "flips", "--agent", "random", "--out", directory)
    assert done.returncode == 2
    assert "already holds a study with other settings" in done.stderr
    assert "repeat its settings to resume it, or give another --out" in done.stderr


def test_without_out_the_same_command_finds_its_directory_again(tmp_path):
    for _ in range(2):
        done = typed("run", "flips", "--agent", "round-robin", "--trials", 1, "--no-report", cwd=tmp_path)
    assert "21 of 21 trials are done already" in done.stdout
    assert len(list((tmp_path / "lockprobe-runs").iterdir())) == 1


def test_a_closed_pipe_is_no_error(directory):
    done = subprocess.run(
        f"{sys.executable} -m lockprobe export {directory} | head -n 1", shell=True, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.stdout.startswith("key,agent")
    assert done.stderr == ""
