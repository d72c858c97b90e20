"""What the package adds keeps Lockprobe's contracts, and does what it says."""

import json
import subprocess
import sys

import pytest
from latecomer.late import Late
from latecomer.untold import untold

import lockprobe
from lockprobe.statistics.measures import find_measure, measured
from lockprobe.testing import (
    check_agent,
    check_box,
    check_intervention,
    check_measure,
    check_plant,
    make_trial,
    play_trials,
)

CONDITIONS = ["truth", "late?lag=1", "late?lag=2"]


@pytest.mark.parametrize("lag", [0, 1, 3])
def test_late_keeps_the_contract(lag):
    check_intervention(Late(lag=lag), doses=(0, 1, 3))


def test_late_tells_what_was_true_before():
    trial = make_trial([3, 0, 2, 1], condition=[Late(lag=1)])
    assert [step.moved for step in trial.steps] == [True, False, True, True]
    assert [step.told_moved for step in trial.steps] == [None, True, False, True]


def test_the_others_keep_theirs():
    check_agent("stubborn?tries=3")
    check_plant("weighed?friction=1.5")
    check_box("gate?bolts=5")
    check_measure("untold")


def test_they_play_together():
    late = play_trials("stubborn", 10, box="gate", plant="weighed", condition="late?lag=2", max_steps=40)
    soon = play_trials("stubborn", 10, box="gate", plant="weighed", max_steps=40)
    assert [measured(trials, find_measure("untold")).value > 0 for trials in (soon, late)] == [False, True]
    assert late[0].steps[0].sensed["force_n"] in (2.0, 20.0)
    assert untold(late[0]) == 2 / len(late[0].steps)
    with pytest.raises(lockprobe.UserMistake, match="expected a whole number from 0"):
        lockprobe.run_trial(condition="late?lag=-1")


def command(*words):
    return subprocess.run(
        [sys.executable, "-m", "lockprobe", *words], capture_output=True, text=True, check=True
    ).stdout


@pytest.mark.parametrize(
    ("listing", "name"),
    [("interventions", "late"), ("measures", "untold")],
)
def test_lockprobe_lists_them(listing, name):
    rows = {row["spec"]: row for row in map(json.loads, command("list", listing, "--json").splitlines())}
    assert rows[name]["package"] == "lockprobe-latecomer 0.1.0"
    assert rows[name]["what"][0].isupper()


def test_a_study_is_played_with_them(tmp_path):
    assert "gate " in command("box", "list")
    asked = lockprobe.study(
        agent=["stubborn", "random"], box="gate?bolts=4", plant="weighed", p=[0, 0.3], trials=2, repetitions=1
    )
    trials = lockprobe.run_study(asked, tmp_path)
    assert {(trial.agent, trial.box) for trial in trials} == {("stubborn", "gate-4"), ("random", "gate-4")}
    assert len(lockprobe.tidy(trials)) == sum(len(trial.steps) for trial in trials)


def test_a_sweep_over_the_lag_is_reported_with_all_of_them(tmp_path):
    out = tmp_path / "study"
    command("run", "flips", "--agent", "human-inspired", "--plant", "weighed", "--sweep", "late?lag=0,1,2",
            "--trials", "12", "--repetitions", "1", "--out", str(out))  # fmt: skip
    found = lockprobe.results(out)
    assert [row.condition for row in found.where("success", axis="", of="")] == CONDITIONS
    (axis,) = found.design.axes
    assert (axis.axis.key, list(axis.axis.doses.values())) == ("late lag", [0, 1, 2])
    compared = found.where("success_difference", control="truth", axis="late lag", of="")
    assert [row.condition for row in compared] == CONDITIONS[1:]
    assert found.answer.startswith("Higher doses of late")
    shares = [row.value for row in found.where("measures.untold")]
    assert shares[0] == 0 < shares[1] < shares[2]
    assert "come from lockprobe-latecomer 0.1.0" in command("verify", str(out))
