"""``lockprobe power``, as typed: one table and one shape of JSON for every design."""

import json

import pytest

from lockprobe.simulation.power.people import People, people_power
from lockprobe.simulation.power.simulator import Simulation

FEW = ("--trials", "9,30", "--studies", 10, "--workers", 1)


@pytest.fixture
def asked(lockprobe):
    """The rows that a design finds as JSON, and its words."""

    def ask(*words):
        found, said = json.loads(lockprobe("power", *words, "--json")[1]), lockprobe("power", *words)[1]
        return found["rows"], said

    return ask


def test_power_for_a_stated_effect(asked):
    rows, said = asked("--success", "0.2,0.7", "--p", "0,0.4", "--trials", "9,30", "--studies", 20, "--workers", 1)
    found = next(row for row in rows if row["test"].startswith("greatest difference"))["trials"]
    assert [one["n"] for one in found["measured"]] == [9, 30]
    assert found["needed"] <= 30
    assert {"n=30", f"{found['measured'][1]['power']:.2f}±{found['measured'][1]['error']:.2f}"} <= {*said.split()}


def test_blocks_of_a_study_of_controls(asked):
    effect = ("--success", "0.2,0.7,0.2,0.2,0.7,0.7,0.2")
    (small, large), said = asked("why", *effect, "--trials", "30,150", "--studies", 20, "--workers", 1)
    assert (small["blocks"], large["blocks"], large["truth"]) == (30, 150, "says")
    assert large["right"] >= 0.8
    assert large["claims"]["last"] >= 10
    assert "as stated" in said


def test_of_every_condition_against_its_control_by_hand(asked):
    """The conditions in the order of a study: truth, flip rates, conditions."""
    words = ("--p", "0,0.4", "--condition", "nudge", "--condition", "told=warn", "--success", "0.2,0.8,0.8,0.2")
    rows, said = asked(*words, *FEW)
    rows = {row["condition"]: row for row in rows}
    families = {label: (row["family"], row["choices"]) for label, row in rows.items()}
    assert families == {"flip?p=0.4": ("flip rate", 1), "nudge": ("", 2), "told": ("", 2)}
    assert {(row["agent"], row["control"], row["control success"]) for row in rows.values()} == {
        ("as stated", "truth", 0.2)
    }
    powers = [rows[name]["trials"]["measured"][-1]["power"] for name in ("nudge", "told")]
    assert powers[0] > 0.5 > powers[1]
    assert "Assumption: trials share no luck under different conditions" in said


def test_of_a_strategy_that_is_played_and_of_a_study_file(tmp_path, asked, monkeypatch):
    """It plays fewer blocks here than the thousand that it takes by itself."""
    monkeypatch.setattr("lockprobe.simulation.power.conditions.POOL", 100)
    file = tmp_path / "shaky.toml"
    file.write_text('study = "flips"\nagent = "human-inspired"\np = [0]\nsweep = "tremble?p=0,0.5,1"\n', "utf-8")
    rows, _ = asked(file, *FEW)
    assert [(row["agent"], row["family"], row["condition"]) for row in rows] == [
        ("human-inspired", "tremble p", "tremble?p=0.5"),
        ("human-inspired", "tremble p", "tremble?p=1"),
    ]
    assert rows[0]["control success"] == 1 > rows[0]["success"] > rows[1]["success"]
    assert rows[1]["trials"]["measured"][-1]["power"] == 1


def test_it_says_how_many_persons_each_design_needs_and_what_it_assumes(asked):
    words = ("--people", "--success", "0.4,0.6", "--studies", 5, "--workers", 1, "--persons", "20,60")
    rows, said = asked(*words, "--boxes-each", 2, "--seed", 2)
    assert "chosen by eye" in said
    models = [People(success=(0.4, 0.6), design=design, boxes=2) for design in ("within", "between")]
    how = Simulation(trials=(20, 60), studies=5)
    for row, of in zip(rows[1::3], people_power(models, how, seed=2), strict=True):
        assert row["persons"]["needed"] == of.trials
        measured = [(one["n"], one["power"]) for one in row["persons"]["measured"]]
        assert measured == [(rate.trials, rate.power) for rate in of.measured]
    assert [row["person sd"] for row in rows] == [0.5, 1, 1.5] * 2


def test_over_boxes_it_says_the_share_of_studies(asked):
    rows, said = asked("--over-boxes", "5,20", "--success", "0.2,0.7", "--trials", "1,5", "--workers", 1)
    assert [(row["boxes"], row["trials"]) for row in rows] == [(5, 1), (20, 1), (5, 5), (20, 5)]
    assert rows[0]["power"] < 0.5 < rows[3]["power"]
    assert "1000 simulated studies" in said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("what", "why, a study file ending in .toml, or nothing"),
        ("nowhere.toml", "cannot be read"),
        ("--success 0.2,x", "numbers separated by commas"),
        ("--success 0.2,0.7", "one share from 0 to 1 for each of 7 flip rates"),
        ("--success 0.2,1.7 --p 0,0.4", "got '0.2,1.7'"),
        ("--success 0.2,0.7 --p 0.5,0.500000001", "differ by 0.000001"),
        ("--p 0,0.4", "--success: got None, expected success under each condition"),
        ("--trials 1", "numbers of at least 2"),
        ("--trials nan", "whole numbers"),
        ("--trials 1e300", "at most 10000"),
        ("--condition nudge", "--success: got None, expected success under each condition"),
        ("--condition nudge --success 0.2,nan", "each of 2 conditions: truth; nudge"),
        ("--condition nudge --agent llm:local", "a strategy that ships, or --success"),
        ("--agent random --p 0", "a control and another condition"),
        ("why --success 0.2,0.5", "7 shares from 0 to 1, for truth, lie, truth-truth"),
        ("why --condition nudge", "power of why cannot be combined with --condition"),
        ("why --people --success 0.4,0.6", "--people cannot be combined with why"),
        ("--people", "--success: got None"),
        ("--people --success 0.4", "two or more shares"),
        ("--people --success 0.4,0.6 --persons 9", "10 or more in all"),
        ("--people --success 0.4,0.6 --persons x", "persons: got 'x'"),
        ("--boxes-each 2", "power of flip rates cannot be combined with --boxes-each"),
        ("--over-boxes 5", "--success: got None"),
        ("--over-boxes 5 --persons 40", "power of --over-boxes cannot be combined with --persons"),
        ("--over-boxes 2 --success 0.2,0.4", "at least 5, for a sentence on boxes like these"),
        ("--over-boxes 5 --success 0.2,0.4 --trials 0", "numbers of at least 1"),
    ],
)
def test_mistakes_are_one_line(lockprobe, words, message):
    status, said, error = lockprobe("power", *words.split())
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert message in error
