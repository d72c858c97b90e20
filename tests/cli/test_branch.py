"""``lockprobe branch``: forks a study's trials, says what one report did, and goes on where it stopped."""

import json

import pytest
from typed import typed as run

STUDY = ["--agent", "cognitive:insistent", "--p", "0,0.4", "--trials", "4", "--repetitions", "1", "--no-report"]


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    where = tmp_path_factory.mktemp("branch") / "study"
    assert run("run", "flips", *STUDY, "--out", where).returncode == 0
    return where


def test_it_prints_a_row_for_every_place_and_arm_and_resumes(directory):
    command = ("branch", directory, "--at", "3,onset", "--told", "lie,retracted", "--act", "random", "--times", "2")
    first = run(*command)
    assert first.returncode == 0
    assert "after 3, onset; arms truth, lie, retracted, random; 2 continuations each" in first.stdout
    rows = [line.split() for line in first.stdout.splitlines() if line.startswith("cognitive:insistent  ")]
    assert {(row[1], row[2], row[3]) for row in rows if "trials" not in row[1]} >= {
        ("p=0", "3", "lie"),
        ("p=0.4", "3", "random"),
        ("p=0", "onset", "retracted"),
    }
    assert "No effect on success was detected." in first.stdout or "the success of" in first.stdout
    again = run(*command)
    assert "forks are done already" in again.stdout
    assert [line for line in again.stdout.splitlines() if "lie" in line and "%" in line] == [
        line for line in first.stdout.splitlines() if "lie" in line and "%" in line
    ]


def test_as_json_it_has_every_effect_with_its_interval(directory):
    done = run("branch", directory, "flips/cognitive:insistent/p=0.4", "--at", "5", "--json")
    events = [json.loads(line) for line in done.stdout.splitlines()]
    assert events[0]["event"] == "begin"
    effects = events[-1]["effects"]
    assert {(one["condition"], one["where"], one["arm"]) for one in effects} == {("p=0.4", "5", "lie")}
    assert {one["outcome"] for one in effects} >= {"solved", "steps", "repeats", "choice"}
    assert all(one["change"]["blocks"] <= 4 for one in effects)


def test_the_estimate_plays_nothing(directory, tmp_path):
    before = sorted((directory / "forks").rglob("*")) if (directory / "forks").exists() else []
    done = run("branch", directory, "--at", "4", "--estimate")
    assert "cognitive:insistent: 16 forks, at most 256 steps" in done.stdout
    assert (sorted((directory / "forks").rglob("*")) if before else []) == before


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--at", "25"], "a place after which a trial goes on"),
        (["--told", "joke"], "one of truth, lie, retracted"),
        (["--act", "force=door"], "one of revolute-left"),
        (["nothing"], "no trial is called 'nothing'"),
        (["--then", "later"], "--then"),
    ],
)
def test_mistakes_are_one_line(directory, asked, said):
    done = run("branch", directory, *asked)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_status_counts_the_forks(directory):
    run("branch", directory, "--at", "4")
    facts = json.loads(run("status", directory, "--json").stdout)
    assert facts["forks"] >= 16
    assert facts["done"] == 8
