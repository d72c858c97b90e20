"""``lockprobe power``, as typed."""

import json

import pytest
from typed import typed


def test_power_for_a_stated_effect():
    stated = ("power", "--success", "0.2,0.7", "--p", "0,0.4", "--trials", "9,30", "--studies", 20, "--workers", 1)
    tests = json.loads(typed(*stated, "--json").stdout)["tests"]
    found = next(row for row in tests if row["question"] == "success")
    assert [step["trials"] for step in found["measured"]] == [9, 30]
    assert found["trials_needed"] <= 30
    said = typed(*stated).stdout
    assert "trials per flip rate for 0.8" in " ".join(said.split())
    assert "n=30" in said


def test_blocks_of_a_study_of_controls():
    stated = ("power", "why", "--success", "0.2,0.7,0.2,0.2,0.7,0.7,0.2", "--trials", "30,150", "--studies", 20)
    small, large = json.loads(typed(*stated, "--json").stdout)["rates"]
    assert (small["blocks"], large["blocks"], large["truth"]) == (30, 150, "says")
    assert large["right"] >= 0.8
    assert large["claims"]["last"] >= 10
    said = typed(*stated).stdout
    assert "as stated" in said
    assert "Arms share no luck here" in said


STATED = ("power", "--p", "0,0.4", "--condition", "nudge", "--condition", "told=warn", "--success", "0.2,0.8,0.8,0.2")
FEW = ("--trials", "9,30", "--studies", 10, "--workers", 1)


def test_of_every_condition_against_its_control_by_hand():
    """The conditions in the order of a study: truth, flip rates, conditions."""
    found = json.loads(typed(*STATED, *FEW, "--json").stdout)
    rows = {row["condition"]: row for row in found["conditions"]}
    assert {label: (row["family"], row["choices"]) for label, row in rows.items()} == {
        "flip?p=0.4": ("flip rate", 1),
        "nudge": ("", 2),
        "told": ("", 2),
    }
    assert {(row["agent"], row["control"], row["control_success"]) for row in rows.values()} == {
        ("as stated", "truth", 0.2)
    }
    assert rows["nudge"]["measured"][-1]["power"] > 0.5 > rows["told"]["measured"][-1]["power"]
    said = typed(*STATED, *FEW).stdout
    assert "trials per condition for 0.8" in said
    assert "Assumption: trials share no luck under different conditions" in said
    assert "there is nothing to detect" in said


def test_of_a_strategy_that_is_played_and_of_a_study_file(tmp_path, lockprobe, monkeypatch):
    """It plays fewer blocks here than the thousand that it takes by itself."""
    monkeypatch.setattr("lockprobe.simulation.power.conditions.POOL", 100)
    file = tmp_path / "shaky.toml"
    file.write_text('study = "flips"\nagent = "human-inspired"\np = [0]\nsweep = "tremble?p=0,0.5,1"\n', "utf-8")
    found = json.loads(lockprobe("power", file, *FEW, "--json")[1])["conditions"]
    assert [(row["agent"], row["family"], row["condition"]) for row in found] == [
        ("human-inspired", "tremble p", "tremble?p=0.5"),
        ("human-inspired", "tremble p", "tremble?p=1"),
    ]
    assert found[0]["control_success"] == 1 > found[0]["success"] > found[1]["success"]
    assert found[1]["measured"][-1]["power"] == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("power", "what"), "why, a study file ending in .toml, or nothing"),
        (("power", "why", "--success", "0.2,0.5"), "7 shares from 0 to 1, for truth, lie, truth-truth"),
        (("power", "--success", "0.2,x"), "numbers separated by commas"),
        (("power", "--trap", "0.5"), "success at each flip rate"),
        (("power", "--success", "0.2,0.7"), "one share for each of 7 flip rates"),
        (("power", "--success", "0.2,1.7", "--p", "0,0.4"), "got 1.7"),
        (("power", "--trials", "1"), "numbers of at least 2"),
        (("power", "--trials", "nan"), "whole numbers"),
        (("power", "--trials", "1e300"), "at most 10000"),
        (("power", "--success", "0.2,0.7", "--p", "0,0.4", "--trap", ""), "trap: got ''"),
        (("power", "--success", "0.2,0.7", "--p", "0.5,0.500000001"), "differ by 0.000001"),
        (("power", "--target", "1.5"), "target power"),
        (("power", "--condition", "nudge"), "success under each condition, or --agent with a strategy to be played"),
        (("power", "--condition", "nudge", "--success", "0.2,nan"), "each of 2 conditions: truth; nudge"),
        (("power", "--condition", "nudge", "--success", "0.2,0.3", "--shared", "2"), "shared: got 2.0"),
        (
            ("power", "--condition", "nudge", "--success", "0.2,0.3", "--trap", "0.5"),
            "conditions cannot be combined with --trap: --trap is for flip rates alone",
        ),
        (("power", "--shared", "0.5"), "--shared is for conditions"),
        (
            ("power", "why", "--condition", "nudge"),
            "power why cannot be combined with --condition: --condition is for conditions",
        ),
        (("power", "--condition", "nudge", "--agent", "llm:local"), "a strategy that ships, or --success"),
        (("power", "--agent", "random", "--p", "0"), "a control and another condition"),
        (("power", "nowhere.toml"), "cannot be read"),
    ],
)
def test_mistakes_are_one_line(lockprobe, arguments, message):
    status, said, error = lockprobe(*arguments)
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert message in error
