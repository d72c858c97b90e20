"""``lockprobe power``, as typed."""

import json

import pytest
from typed import typed

from lockprobe.simulation.power.people import EFFECT_SD, PERSON_SD, People, people_power
from lockprobe.simulation.power.simulator import Simulation


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
    effect = ("--success", "0.2,0.7,0.2,0.2,0.7,0.7,0.2")
    stated = ("power", "why", *effect, "--trials", "30,150", "--studies", 20, "--workers", 1)
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


PEOPLE = ("power", "--people", "--success", "0.4,0.6", "--studies", 5, "--workers", 1)


def test_it_says_how_many_persons_each_design_needs_and_what_it_assumes(lockprobe):
    said = " ".join(lockprobe(*PEOPLE, "--persons", "20,200")[1].split())
    assert "within persons, 2 boxes each" in said
    assert "between persons, 2 boxes each under one condition" in said
    assert said.count("n=20 n=200 persons for 0.8") == 2
    assert said.count(f"SD {PERSON_SD:g} and {EFFECT_SD:g}") == 2
    assert "chosen by eye" in said


def test_in_json_the_assumptions_stand_beside_the_numbers(lockprobe):
    asked = ("--boxes-each", 2, "--person-sd", 1.5, "--effect-sd", 0.2, "--target", 0.9, "--seed", 2)
    asked += ("--persons", "20,60")
    found = json.loads(lockprobe(*PEOPLE, *asked, "--json")[1])
    assert (found["boxes"], found["success"], found["target"], found["studies"]) == (2, [0.4, 0.6], 0.9, 5)
    models = [
        People(success=(0.4, 0.6), design=design, boxes=2, person_sd=1.5, effect_sd=0.2)
        for design in ("within", "between")
    ]
    how = Simulation(trials=(20, 60), target=0.9, studies=5)
    for row, of in zip(found["designs"][1::3], people_power(models, how, seed=2), strict=True):
        assert (row["person_sd"], row["effect_sd"], row["persons_needed"]) == (1.5, 0.2, of.trials)
        assert [(one["persons"], one["power"]) for one in row["measured"]] == [
            (rate.trials, rate.power) for rate in of.measured
        ]
    said = lockprobe(*PEOPLE, "--persons", 15)
    assert said[0] == 2
    assert "20 or more in all, 10 under each condition" in said[2]


def test_over_boxes_it_says_the_share_of_studies(lockprobe):
    asked = ("power", "--over-boxes", "5,20", "--success", "0.2,0.7", "--trials", "1,5", "--workers", 1)
    rows = json.loads(lockprobe(*asked, "--json")[1])["power"]
    assert [(row["boxes"], row["trials"]) for row in rows] == [(5, 1), (20, 1), (5, 5), (20, 5)]
    assert rows[0]["power"] < 0.5 < rows[3]["power"]
    said = lockprobe(*asked)[1]
    assert "1000 simulated studies" in said
    assert f"{rows[3]['power']:.2f}" in said.splitlines()[2].split()


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
        (("power", "--condition", "nudge", "--success", "0.2"), "each of 2 conditions: truth; nudge"),
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
        (("power", "why", "--trials", "1"), "numbers of at least 2"),
        (("power", "--over-boxes", "5", "--success", "0.2,0.4", "--trials", "0"), "numbers of at least 1"),
        (("power", "--over-boxes", "5", "--success", "0.2,0.4", "--effect-sd", "nan"), "effect-sd: got nan"),
        (("power", "--people"), "--success is missing, expected the share of boxes opened"),
        (("power", "--people", "--success", "0.4"), "two or more shares"),
        (("power", "why", "--people", "--success", "0.4,0.6"), "--people cannot be combined with why"),
        (("power", "--people", "--success", "0.4,0.6", "--p", "0,0.4", "--trap", "0.5,0.1"), "--p, --trap"),
        (("power", "--boxes-each", "2"), "is for --people"),
        (("power", "--over-boxes", "2", "--success", "0.2,0.4"), "at least 5, for a sentence on boxes like these"),
        (("power", "--over-boxes", "5", "--persons", "40"), "--over-boxes cannot be combined with --persons"),
        (("power", "--over-boxes", "5"), "--success is missing"),
        (
            ("power", "--over-boxes", "5", "--studies", "9"),
            "--studies is for flip rates alone and conditions and power why and --people",
        ),
        (("power", "--persons", "40"), "is for --people"),
        (("power", "--people", "--success", "0.4,0.6", "--persons", "9"), "10 or more in all"),
        (("power", "--people", "--success", "0.4,0.6", "--persons", "x"), "persons: got 'x'"),
    ],
)
def test_mistakes_are_one_line(lockprobe, arguments, message):
    status, said, error = lockprobe(*arguments)
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert message in error
