"""``lockprobe power``, as typed."""

import json
import re

import pytest
from typed import typed

from lockprobe.simulation.power.people import EFFECT_SD, PERSON_SD, People, people_needed, power_with


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


def test_it_says_how_many_persons_each_design_needs_and_what_it_assumes(lockprobe):
    _, said, _ = lockprobe("power", "--people", "--success", "0.4,0.6")
    model = People(success=(0.4, 0.6))
    for design in ("within", "between"):
        line = next(line for line in said.splitlines() if line.startswith(f"{design} persons"))
        assert str(people_needed(model, design).people) in line.split()
    assert "chosen by eye" in " ".join(said.split())
    assert f"SD {PERSON_SD:g} and {EFFECT_SD:g}" in said


def test_in_json_the_assumptions_stand_beside_the_numbers(lockprobe):
    asked = ("--success", "0.4,0.6,0.5", "--boxes-each", 2, "--person-sd", 1.5, "--effect-sd", 0.2, "--target", 0.9)
    found = json.loads(lockprobe("power", "--people", *asked, "--json")[1])
    model = People(success=(0.4, 0.6, 0.5), boxes=2, person_sd=1.5, effect_sd=0.2)
    assert (found["boxes"], found["person_sd"], found["effect_sd"], found["target"]) == (2, 1.5, 0.2, 0.9)
    rows = [row for row in found["designs"] if row["person_sd"] == 1.5]
    assert [row["people"] for row in rows] == [people_needed(model, one, 0.9).people for one in ("within", "between")]


def test_for_a_number_of_persons_it_says_their_power_and_the_smallest_effect(lockprobe):
    asked = ("power", "--people", "--success", "0.4,0.6", "--persons", "15,80")
    _, said, _ = lockprobe(*asked)
    model = People(success=(0.4, 0.6))
    lines = [line for line in said.splitlines() if line.startswith("between persons")]
    found = power_with(model, "between", 80)
    assert [line.split()[2] for line in lines] == ["15", "80", "15", "80"]
    assert "too few" in lines[0]
    assert f"{found.power:.2f}" in lines[1].split()
    assert re.search(rf"≤ {found.below - 0.005:.2f}, ≥ {found.above + 0.005:.2f}", lines[3])
    rows = json.loads(lockprobe(*asked, "--json")[1])["designs"]
    few, enough = (row for row in rows if (row["design"], row["person_sd"]) == ("between", PERSON_SD))
    assert (few["people"], few["power"], few["below"]) == (15, None, None)
    assert (enough["people"], enough["power"], enough["above"]) == (80, found.power, found.above)


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
            "--studies is for flip rates alone and conditions and power why",
        ),
        (("power", "--persons", "40"), "is for --people"),
        (("power", "--people", "--success", "0.4,0.6", "--persons", "9"), "10 or more persons"),
        (("power", "--people", "--success", "0.4,0.6", "--persons", "x"), "persons: got 'x'"),
    ],
)
def test_mistakes_are_one_line(lockprobe, arguments, message):
    status, said, error = lockprobe(*arguments)
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert message in error
