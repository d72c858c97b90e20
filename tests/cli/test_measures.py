"""``lockprobe list measures``: the list, and the means of a study."""

import json

import pytest
import strangers
from builders import small_study, write_study

from lockprobe.statistics.measures import MEASURES, measured
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "S", small_study(["random", "human-inspired"], p=[0.0, 0.6], trials=3))


def test_the_list_has_every_measure_with_what_it_is(lockprobe):
    rows = [json.loads(line) for line in lockprobe("list", "measures", "--json")[1].splitlines()]
    assert [row["spec"] for row in rows] == list(MEASURES)
    assert all(row["what"] for row in rows)
    assert lockprobe("list", "measures")[1].splitlines()[0].startswith("solved          Whether the target moved")


def test_of_a_study_without_trials_it_says_so(lockprobe, tmp_path):
    nothing = write_study(tmp_path / "none", small_study(), [])
    for more in ([], ["--json"]):
        assert lockprobe("list", "measures", nothing, *more) == (0, "", f"No trial is on record in {nothing}.\n")


def test_the_means_of_a_study_are_those_of_its_conditions(lockprobe, directory):
    rows = [json.loads(line) for line in lockprobe("list", "measures", directory, "--json")[1].splitlines()]
    assert len(rows) == 4 * len(MEASURES)
    trials = [trial for trial in load(directory) if trial.agent == "random" and trial.p == 0.6]
    (expected,) = measured(trials, ["redundant"])
    (row,) = (
        row for row in rows if (row["agent"], row["condition"], row["name"]) == ("random", "flip?p=0.6", "redundant")
    )
    assert (row["value"], row["low"], row["high"], row["n"]) == (expected.value, expected.low, expected.high, 6)
    status, out, err = lockprobe("list", "measures", directory, "--measure", "solved")
    assert (status, err, len(out.splitlines())) == (0, "", 5)
    assert [line.split()[:3] for line in out.splitlines()[1:3]] == [
        ["random", "truth", "solved"],
        ["random", "flip?p=0.6", "solved"],
    ]


def test_every_condition_has_every_measure_those_of_packages_too(lockprobe, tmp_path, monkeypatch):
    """A study without flips. What breaks, though nobody asked for it, is left out and named."""
    points = {"measures": {"untold": "untold", "odd": "breaks"}}
    strangers.install(tmp_path, monkeypatch, points=points)
    asked = {"agent": ["random", "round-robin"], "p": [0], "condition": ["nudge", "drop?p=0.5"], "trials": 3}
    planned = study("flips", **asked, sweep="tremble?p=0,0.2,0.4", repetitions=1)
    directory = write_study(tmp_path / "none flipped", planned)
    status, out, err = lockprobe("list", "measures", directory, "--json")
    rows = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    cells = dict.fromkeys((row["agent"], row["condition"]) for row in rows)
    assert list(cells) == [(agent, one.label) for agent in planned.agents for one in planned.conditions]
    assert [row["name"] for row in rows] == [*MEASURES, "untold"] * len(cells)
    trembling = next(row for row in rows if row["condition"] == "tremble?p=0.4")
    assert trembling["doses"] == {"tremble.p": 0.4}
    silent = [row["value"] for row in rows if (row["name"], row["condition"]) == ("untold", "drop?p=0.5")]
    assert all(0 < value < 1 for value in silent)
    assert err.startswith("odd is left out: measure 'odd'")
    assert err.count("\n") == 1


def test_a_measure_of_one_s_own_is_named_on_the_command_line(lockprobe, directory, tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch)
    said = lockprobe(
        "list", "measures", directory, "--measure", "python:strange:hasty", "--measure", "untold?weight=2", "--json"
    )
    names = {json.loads(line)["name"]: json.loads(line)["kind"] for line in said[1].splitlines()}
    assert names == {"python:strange:hasty": "share", "untold?weight=2": "mean"}
    status, out, err = lockprobe("list", "measures", directory, "--measure", "python:strange:breaks")
    assert (status, out) == (2, "")
    assert err == "lockprobe: measure 'python:strange:breaks' does not work (ZeroDivisionError: by nothing)\n"
    assert lockprobe("list", "measures", tmp_path / "nowhere")[0] == 2
