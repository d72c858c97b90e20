"""A trial in the terminal: lines from a pipe, keys on a terminal of its own."""

import os
import pty
import re
import select
import subprocess
import termios

import forked
import pytest
from typed import in_process
from typer.testing import CliRunner

from lockprobe.cli import build
from lockprobe.studies.running.single import run_trial

SEED = 16


def play(*words, lines="", seed=SEED):
    return in_process("play", "--seed", seed, *words, stdin=lines).stdout


def said(trial):
    """What a person would enter to do the same, line by line."""
    return "\n".join(step.decision.joint for step in trial.steps)


@pytest.mark.parametrize("flip", ["re-observed", "integrated", "outcome-only"])
def test_it_is_the_trial_that_any_agent_plays_and_at_the_end_truth_stands_beside_told(flip):
    theirs = run_trial(agent="human-inspired", p=0.2, seed=SEED, flip=flip)
    shown = play("--p", 0.2, "--flip", flip, lines=said(theirs) + "\n")
    assert f"You opened the box in {len(theirs.steps)} steps." in shown
    rows = [line.split() for line in shown.splitlines() if re.match(r" +\d+  [A-D] ", line)]
    labels = dict(zip(theirs.joints, theirs.labels, strict=True))
    assert [row[1] for row in rows] == [labels[step.joint] for step in theirs.steps]
    assert [int(row[0]) for row in rows if "<-" in row] == [step.step for step in theirs.steps if step.told_falsely]
    lies = sum(step.told_falsely for step in theirs.steps)
    assert f"{lies} of {len(theirs.steps)} reports were false (flip rate 0.2)" in shown
    assert re.search(r"^  A \(target\): ", shown, re.MULTILINE)
    for spec in ("ideal-observer", "human-inspired", "random"):
        other = run_trial(agent=spec, p=0.2, seed=SEED, flip=flip, assessment=False)
        how = f"{len(other.steps)} steps" if other.solved else "not within 20 steps"
        assert re.search(rf"^  {spec} +{how}$", shown, re.MULTILINE)
    assert "fewest possible          4 steps" in shown


def test_it_says_no_outcome_that_the_report_does_not_give():
    for flip, report in (("re-observed", "You attempted A."), ("outcome-only", "A moved.")):
        panel = play("--p", 0, "--flip", flip, lines="A\nq\n", seed=2)
        assert report in panel.splitlines()
        assert "A did not move." not in panel


def test_the_panel_says_what_changed_on_it_and_asks_in_its_own_order():
    shown = play("--p", 0.4, lines="\n".join("ABCDACQ"), seed=30).splitlines()
    changed = [line.split(": ")[1] for line in shown if line.startswith("Changed on the panel: ")]
    assert changed == ["nothing.", "B.", "B, C.", "D.", "A, D.", "A."]  # D in a lie
    assert {line[:22] for line in shown if line.startswith("Which joint?")} == {"Which joint? D* A B C:"}
    told = play("--p", 0.4, "--flip", "outcome-only", lines="A\nQ\n", seed=8)
    assert "Changed" not in told


def test_nothing_true_is_shown_before_the_end():
    shown = play("--p", 1, "--flip", "outcome-only", lines="B\nB\nB\nq")
    before, _, after = shown.partition("Stopped")
    assert "B did not move." in before  # it always moves: the right revolute is free
    assert "B moved" not in before
    assert after == "; nothing is saved.\n"


def test_a_box_that_is_not_opened_and_too_large_for_thinking():
    shown = play("--box", "chain-8", "--max-steps", 3, lines="A\nA\nA\n")
    assert "The box is not open after 3 steps." in shown
    assert re.search("^  ideal-observer +cannot plan", shown, re.MULTILINE)
    assert re.search("^  you +not within 3 steps$", shown, re.MULTILINE)
    assert max(map(len, shown.splitlines())) <= 80


def test_what_is_no_choice_costs_no_step():
    shown = play(lines="x\n?\n\x1b[31m\n7\nq")
    assert shown.count("Step ") == 1
    assert shown.count("Unknown key") == 3
    assert shown.count("The box has 4 joints") == 2
    assert "\x1b" not in shown


@pytest.mark.parametrize(
    ("lines", "status", "last"),
    [
        ("B\nQuit\n", 0, "Stopped; nothing is saved."),
        ("", 1, "No letter came for step 1, and nothing is saved."),
        ("B\n", 1, "No letter came for step 2, and nothing is saved."),
    ],
)
def test_q_stops_it_and_input_that_ends_too_early_is_a_failure(lines, status, last):
    done = CliRunner().invoke(build(["play"]), ["play", "--seed", str(SEED)], input=lines)
    assert (done.exit_code, done.stdout.endswith(f"\n{last}\n")) == (status, True)


@pytest.mark.parametrize(("key", "status"), [(b"\x03", 130), (b"\x04", 1)])
def test_a_press_is_enough_on_a_terminal_and_whatever_ends_it_leaves_the_terminal_as_it_was(key, status):
    ours, theirs = pty.openpty()
    before, shown = termios.tcgetattr(theirs), b""
    process = forked.start(["play"], stdin=theirs, stdout=theirs, stderr=subprocess.DEVNULL)
    for said, keys in ((b"Step 1", b"\x1b[A"), (b"Unknown key", b"a"), (b"Step 2", key)):  # an arrow is no choice
        while b"Which joint?" not in shown.partition(said)[2] or termios.tcgetattr(theirs) == before:
            shown += os.read(ours, 4096) if select.select([ours], [], [], 0.05)[0] else b""
        os.write(ours, keys)
    assert (process.wait(20), termios.tcgetattr(theirs) == before) == (status, True)
