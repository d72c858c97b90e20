"""A trial in the terminal: lines from a pipe, keys on a terminal of its own."""

import json
import os
import pty
import re
import select
import signal
import termios
from dataclasses import replace

import forked
import pytest
from typed import in_process
from typer.testing import CliRunner

from lockprobe.cli import build
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.trial_json import trial_from_json

SEED = 16
HUMAN = run_trial(agent="human-inspired", p=0.2, seed=SEED)
BLUNT = run_trial(agent="human-inspired", p=0.2, seed=SEED, assessment=False)
CLAIMS = {"moved": "m", "blocked": "n", None: ""}


def play(*words, lines="", claims=True, seed=SEED):
    words = ("--assessment", *words) if claims else words
    return in_process("play", "--seed", seed, *words, stdin=lines).stdout


def said(trial):
    """What a person would enter to do the same, line by line."""
    return "\n".join(key for step in trial.steps for key in (CLAIMS[step.decision.claimed], step.decision.joint) if key)


def bare(trial):
    """A trial without what only its agent is."""
    steps = tuple(replace(step, decision=replace(step.decision, probabilities=None)) for step in trial.steps)
    return replace(trial, agent="", key="", facts={}, steps=steps)


@pytest.mark.parametrize(
    ("flip", "view"),
    [("re-observed", "panel"), ("integrated", "panel"), ("integrated", "text"), ("outcome-only", "text")],
)
def test_it_is_the_trial_that_any_agent_plays(flip, view, tmp_path):
    theirs = run_trial(agent="human-inspired", p=0.2, seed=SEED, flip=flip)
    file = tmp_path / "mine.jsonl"
    play("--p", 0.2, "--flip", flip, "--view", view, "--record", file, lines=said(theirs) + "\n")
    (line,) = file.read_bytes().splitlines()
    mine = trial_from_json(line)
    assert bare(mine) == bare(theirs)
    assert (mine.agent, mine.facts) == ("participant:local", {"view": view, "page": "terminal"})


@pytest.mark.parametrize(
    ("flip", "rule", "report"),
    [
        ("re-observed", "After every step you are told which joints are at position 1.", "You attempted A."),
        ("outcome-only", "After every step you are told whether it moved.", "A moved."),
    ],
)
def test_it_says_no_outcome_that_the_report_does_not_give(flip, rule, report):
    asked = ("--p", 0, "--flip", flip)
    panel = play(*asked, lines="A\nm\nq\n", seed=2)
    assert report in panel.splitlines()
    assert "A did not move." not in panel
    text = play(*asked, "--view", "text", lines="A\nm\nq\n", seed=2)
    assert rule in text.splitlines()
    assert any(line.startswith(report) for line in text.splitlines())


def test_the_panel_says_what_changed_on_it_and_asks_in_its_own_order():
    shown = play("--p", 0.4, lines="\n".join("ABCDACQ"), claims=False, seed=30).splitlines()
    changed = [line for line in shown if line.startswith("Changed on the panel: ")]
    assert [line.split(": ")[1] for line in changed] == [
        "nothing.",
        "B.",
        "B, C.",
        "D.",
        "A, D.",
        "A.",
    ]  # D in a lie
    assert {line[:22] for line in shown if line.startswith("Which joint?")} == {"Which joint? D* A B C:"}
    told = play("--p", 0.4, "--flip", "outcome-only", lines="A\nQ\n", claims=False, seed=8)
    assert "Changed" not in told


def test_nobody_asks_what_was_done_unless_it_is_wanted(tmp_path):
    shown = play("--p", 0.2, "--record", tmp_path / "a.jsonl", lines=said(BLUNT).lower() + "\n", claims=False)
    assert "last action" not in shown
    assert bare(trial_from_json((tmp_path / "a.jsonl").read_bytes().strip())) == bare(BLUNT)


def test_records_are_appended(tmp_path):
    for _ in range(2):
        play("--p", 0.2, "--record", tmp_path / "a.jsonl", lines=said(HUMAN) + "\n")
    assert len((tmp_path / "a.jsonl").read_bytes().splitlines()) == 2


def test_nothing_true_is_shown_before_the_end():
    shown = play("--p", 1, "--view", "text", lines="\n".join([*["B", "m"] * 3, "q"]))
    assert "You attempted B. At 1: none." in shown  # it always moves: the right revolute is free
    before, _, after = shown.partition("Stopped")
    assert "B moved" not in before
    assert after == "; nothing is saved.\n"


def test_at_the_end_truth_stands_beside_told():
    shown = play("--p", 0.2, lines=said(HUMAN) + "\n")
    assert f"You opened the box in {len(HUMAN.steps)} steps." in shown
    flipped = [step.step for step in HUMAN.steps if step.moved != step.told_moved]
    assert flipped
    assert [int(line.split()[0]) for line in shown.splitlines() if "<- false" in line] == flipped
    assert f"{len(flipped)} of {len(HUMAN.steps)} reports were false (flip rate 0.2)" in shown
    assert re.search(r"^  A \(target\)$", shown, re.MULTILINE)
    for spec in ("ideal-observer", "human-inspired", "random"):
        other = run_trial(agent=spec, p=0.2, seed=SEED)
        assert other.solved
        assert re.search(rf"^  {spec} +{len(other.steps)} steps$", shown, re.MULTILINE)
    assert "fewest possible          4 steps" in shown


def test_a_box_that_is_not_opened_and_too_large_for_thinking():
    shown = play("--box", "chain-8", "--max-steps", 3, lines="A\nA\nA\n", claims=False)
    assert "The box is not open after 3 steps." in shown
    assert re.search("^  ideal-observer +cannot plan", shown, re.MULTILINE)
    assert re.search("^  you +not within 3 steps$", shown, re.MULTILINE)


def test_what_is_no_choice_costs_no_step():
    shown = play(lines="x\n?\n\x1b[31m\n7\nq")
    assert shown.count("Step ") == 1
    assert shown.count("Unknown key") == 3
    assert shown.count("The box has 4 joints") == 2
    assert "\x1b" not in shown


AGAIN = f"\nTo go on, play again with --seed {SEED} and one letter more than before."


@pytest.mark.parametrize(
    ("lines", "status", "last"),
    [
        ("q\n", 0, "Stopped; nothing is saved."),
        ("B\nm\nQuit\n", 0, "Stopped; nothing is saved."),
        ("", 1, f"No letter came for step 1, and nothing is saved.{AGAIN}"),
        ("B\n", 1, f"No letter came for step 2, and nothing is saved.{AGAIN}"),
    ],
)
def test_q_stops_it_and_input_that_ends_too_early_is_a_failure(lines, status, last, tmp_path):
    file = tmp_path / "a.jsonl"
    done = CliRunner().invoke(build(["play"]), ["play", "--seed", str(SEED), "--record", str(file)], input=lines)
    assert done.exit_code == status
    assert done.stdout.endswith(f"\n{last}\n")
    assert not file.exists()


def test_a_record_that_cannot_be_written_is_said_before_anything_is_played(tmp_path):
    pipe, locked = tmp_path / "pipe", tmp_path / "locked.jsonl"
    os.mkfifo(pipe)
    locked.touch()
    locked.chmod(0o400)
    for path in (tmp_path, pipe, *([locked] if os.geteuid() else [])):
        done = CliRunner().invoke(build(["play"]), ["play", "--record", str(path)], input=said(HUMAN))
        assert isinstance(done.exception, BadFile)
        assert done.stdout == ""
    kept = tmp_path / "kept.jsonl"
    kept.write_text("{}\n")
    play("--record", kept, lines="q\n")
    assert kept.read_text() == "{}\n"


def test_every_line_fits_into_80_columns():
    lines = play("--p", 0.2, "--box", "chain-8", "--max-steps", 4, lines="\n".join("AmBnCmxmD") + "\n").splitlines()
    assert max(map(len, lines)) <= 80


def test_a_seed_that_nobody_gave_is_said():
    done = CliRunner().invoke(build(["play"]), ["play"], input="q\n")
    seed = int(re.search(r"--seed (\d+)", done.stdout)[1])
    assert CliRunner().invoke(build(["play"]), ["play", "--seed", str(seed)], input="q\n").stdout == done.stdout


def test_a_mistake_is_said_in_one_line(tmp_path):
    for arguments, kind in (
        (("--box", "nothing"), UnknownName),
        (("--p", 2), BadValue),
        (("--p", "0,0.4"), BadValue),
        (("--max-steps", 0), BadValue),
        (("--record", tmp_path / "no" / "a.jsonl"), BadFile),
    ):
        with pytest.raises(kind):
            play(*arguments)


class Terminal:
    """The command on a terminal of its own."""

    def __init__(self, *arguments, **settings):
        self.ours, theirs = pty.openpty()
        self.before = termios.tcgetattr(theirs)
        self._theirs = theirs  # kept open: so that what it was set to can be read afterwards
        self.process = forked.start(
            ["play", "--seed", SEED, *arguments],
            stdin=theirs, stdout=theirs, stderr=theirs, env=os.environ | {"TERM": "xterm"} | settings, start_new_session=True,
        )  # fmt: skip
        self.shown = ""

    def until(self, text):
        seen = len(self.shown)
        while text not in self.shown[seen:]:
            assert select.select([self.ours], [], [], 20)[0], self.shown
            self.shown += os.read(self.ours, 65536).decode()
        return self.shown

    def press(self, keys):
        os.write(self.ours, keys.encode())

    def end(self):
        status = self.process.wait(20)
        while select.select([self.ours], [], [], 0)[0]:
            self.shown += os.read(self.ours, 65536).decode()
        assert termios.tcgetattr(self._theirs) == self.before
        os.close(self._theirs)
        os.close(self.ours)
        return status


def test_a_press_is_enough_on_a_terminal(tmp_path):
    terminal = Terminal("--assessment", "--p", "0.2", "--record", tmp_path / "a.jsonl")
    for step in HUMAN.steps:
        if step.decision.claimed is not None:
            terminal.until("last action do?")
            terminal.press(CLAIMS[step.decision.claimed])
        terminal.until("Which joint?")
        terminal.press(step.decision.joint.lower())
    terminal.until("Recorded")
    assert terminal.end() == 0
    assert "\x1b[" in terminal.shown  # colours
    steps = json.loads((tmp_path / "a.jsonl").read_text())["steps"]
    assert [step["decision"]["joint"] for step in steps] == [step.decision.joint for step in HUMAN.steps]


def test_arrows_choose_nothing_and_ctrl_d_ends():
    terminal = Terminal(NO_COLOR="1")
    terminal.until("Which joint?")
    terminal.press("\x1b[A\x1b[B\x1bOD\n z")
    terminal.until("Unknown key")
    assert "Step 2" not in terminal.shown
    assert "\x1b[3" not in terminal.shown  # no colours
    terminal.press("\x04")
    terminal.until("nothing is saved.")
    assert terminal.end() == 1


def test_ctrl_c_ends_and_leaves_the_terminal_as_it_was():
    terminal = Terminal()
    terminal.until("Which joint?")
    terminal.process.send_signal(signal.SIGINT)
    assert terminal.end() == 130
    assert "Traceback" not in terminal.shown
