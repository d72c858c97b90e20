"""Conditions on the command line: played, resumed, reported, exported, and refused in one line."""

import json

import pytest

from lockprobe.studies.records.read_records import load

ASKED = ("run", "flips", "--agent", "random", "--trials", "2", "--repetitions", "1", "--no-report")
ACTING = ("--condition", "flip?p=0.4 + nudge", "--sweep", "tremble?p=0,0.2")


def test_conditions_are_played_beside_the_truth_and_resumed(lockprobe, tmp_path):
    out = tmp_path / "study"
    status, said, _ = lockprobe(*ASKED, *ACTING, "--out", out)
    assert status == 0
    assert "Study flips on chain-4: 3 conditions: truth; flip?p=0.4 + nudge; tremble?p=0.2" in said
    assert "6 of 6 trials are done already" in lockprobe(*ASKED, *ACTING, "--out", out)[1]
    assert lockprobe("status", out)[0] == 0
    header = lockprobe("export", out)[1].splitlines()[0].split(",")
    assert header[4] == "condition"
    assert lockprobe("replay", out, "flips/random/tremble?p=0.2/rep=1/trial=1")[1].startswith("flips/random/tremble")
    assert "report.html" in lockprobe("report", out)[1]
    found = json.loads((out / "results.json").read_text())
    rows = [row for row in found["rows"] if row["quantity"] == "success" and row["condition"] and not row.get("of")]
    assert [row["condition"] for row in rows] == ["truth", "flip?p=0.4 + nudge", "tremble?p=0.2"]


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        (("--condition", "trembel?p=0.1"), "no intervention is called 'trembel' (did you mean 'tremble'?)"),
        (("--sweep", "tremble?p=0.1"), "expected several values of a dose"),
        (("--condition", "nudge + rgb"), "a plant with a camera"),
        (("--condition", "python:nowhere:Nothing"), "python:nowhere:Nothing"),
        (("--condition", "lies="), "condition: got 'lies=', expected NAME=SPEC, for example lies=flip?p=0.4"),
        (("--condition", "=nudge"), "condition: got '=nudge', expected NAME=SPEC"),
        (("--condition", "flip"), "got 'flip', expected one that does something; without p= it is the truth"),
        (("--condition", "truth=nudge"), "got 'truth=nudge', expected another name: truth is a condition"),
        (("--condition", "nudge=flip?p=0.4"), "expected another name: nudge is a condition"),
        (("--condition", "x=nudge", "--condition", "y=nudge"), "another condition than x, which is the same"),
    ],
)
def test_what_cannot_be_played_is_refused_in_one_line(lockprobe, tmp_path, asked, expected):
    status, _, said = lockprobe(*ASKED, *asked, "--out", tmp_path / "study")
    assert status == 2
    assert expected in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "study").exists()


def test_a_condition_has_a_name_of_one_s_own(lockprobe, tmp_path):
    named = ("--condition", "told twice=flip?p=0.4 + nudge", "--condition", "symbolic?tell=outcome")
    assert lockprobe(*ASKED, *named, "--out", tmp_path / "study")[0] == 0
    trials = load(tmp_path / "study")
    assert {trial.condition for trial in trials} == {"truth", "told twice", "symbolic?tell=outcome"}
    (mine,) = {(trial.specs, tuple(trial.doses.items())) for trial in trials if trial.condition == "told twice"}
    assert mine == (("flip?p=0.4", "nudge"), (("flip.p", 0.4),))


NAMED = """
agent = ["random"]
trials = 1
{more}
[[condition]]
name = "nudged"
spec = "flip?p=0.4 + nudge"
[[condition]]
name = "other"
spec = "{spec}"
"""


def test_one_condition_under_two_names_is_refused_in_one_line(lockprobe, tmp_path):
    (tmp_path / "mine.toml").write_text(NAMED.format(spec="flip?p=0.4", more="p = [0, 0.4]"))
    status, _, said = lockprobe("run", tmp_path / "mine.toml", "--no-report", "--out", tmp_path / "study")
    assert status == 2
    assert "condition: got 'other', expected another condition than flip?p=0.4, which is the same" in said
    assert len(said.splitlines()) == 1


def test_a_name_of_ones_own_for_the_truth_is_no_second_condition(lockprobe, tmp_path):
    (tmp_path / "mine.toml").write_text(NAMED.format(spec="truth", more="p = [0, 0.4]"))
    status, said, _ = lockprobe("run", tmp_path / "mine.toml", "--no-report", "--out", tmp_path / "study")
    assert status == 0
    assert "3 conditions: other; flip?p=0.4; nudged" in said
