"""``lockprobe measures``: the list, and the means of a study."""

import json

import pytest
import strangers
from builders import small_study, write_study

from lockprobe.analysis.measures import MEASURES, measured
from lockprobe.studies.journal import load


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "S", small_study(["random", "human-inspired"], p=[0.0, 0.6], trials=3))


def test_the_list_has_every_measure_with_what_it_is(lockprobe):
    rows = [json.loads(line) for line in lockprobe("measures", "--json")[1].splitlines()]
    assert [row["spec"] for row in rows] == list(MEASURES)
    assert all(row["what"] for row in rows)
    assert lockprobe("measures")[1].splitlines()[0].startswith("solved          Whether the target moved")


def test_of_a_study_without_trials_it_says_so(lockprobe, tmp_path):
    nothing = write_study(tmp_path / "none", small_study(), [])
    for more in ([], ["--json"]):
        assert lockprobe("measures", nothing, *more) == (0, "", f"No trial is on record in {nothing}.\n")


def test_the_means_of_a_study_are_those_of_its_conditions(lockprobe, directory):
    rows = [json.loads(line) for line in lockprobe("measures", directory, "--json")[1].splitlines()]
    assert len(rows) == 4 * len(MEASURES)
    trials = [trial for trial in load(directory) if trial.agent == "random" and trial.p == 0.6]
    (expected,) = measured(trials, ["redundant"])
    (row,) = (row for row in rows if (row["condition"], row["name"]) == ("flips/random/flip?p=0.6", "redundant"))
    assert (row["value"], row["low"], row["high"], row["n"]) == (expected.value, expected.low, expected.high, 6)
    status, out, err = lockprobe("measures", directory, "--measure", "solved")
    assert (status, err, len(out.splitlines())) == (0, "", 5)
    assert "flips/human-inspired/truth" in out


def test_a_measure_of_one_s_own_is_named_on_the_command_line(lockprobe, directory, tmp_path, monkeypatch):
    strangers.install(tmp_path, monkeypatch)
    said = lockprobe(
        "measures", directory, "--measure", "python:strange:hasty", "--measure", "untold?weight=2", "--json"
    )
    names = {json.loads(line)["name"]: json.loads(line)["kind"] for line in said[1].splitlines()}
    assert names == {"python:strange:hasty": "share", "untold?weight=2": "mean"}
    status, out, err = lockprobe("measures", directory, "--measure", "python:strange:breaks")
    assert (status, out) == (2, "")
    assert err == "lockprobe: measure 'python:strange:breaks' does not work (ZeroDivisionError: by nothing)\n"
    assert lockprobe("measures", tmp_path / "nowhere")[0] == 2
