"""``lockprobe power``, as typed: one table and one shape of JSON for every design."""

import json

import pytest

FEW = ("--trials", "9,30", "--studies", 10)


@pytest.fixture
def asked(lockprobe, monkeypatch):
    """The rows that a design finds as JSON; without other processes, which take long to start."""
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    return lambda *words: json.loads(lockprobe("power", *words, "--json")[1])["rows"]


def test_of_every_condition_against_its_control_by_hand(asked, lockprobe):
    """The conditions in the order of a study: truth, flip rates, conditions."""
    words = ("--p", "0,0.4", "--condition", "nudge", "--condition", "told=warn", "--success", "0.2,0.8,0.8,0.2")
    rows, said = asked(*words, *FEW), lockprobe("power", *words, *FEW)[1]
    rows = {row["detected"]: row for row in rows}
    families = {label: (row["family"], row["choices"]) for label, row in rows.items()}
    assert families == {"flip?p=0.4": ("flip rate", 1), "nudge": ("", 2), "told": ("", 2)}
    assert {row["control success"] for row in rows.values()} == {0.2}
    first, last = rows["nudge"]["trials"]["measured"]
    assert (first["n"], last["n"]) == (9, 30)
    assert last["power"] > 0.5 > rows["told"]["trials"]["measured"][1]["power"]
    assert {"n=30", f"{last['power']:.2f}±{last['error']:.2f}"} <= {*said.split()}
    assert "trials share no luck" in said


def test_of_a_study_file(tmp_path, asked):
    file = tmp_path / "shaky.toml"
    file.write_text('study = "flips"\nagent = "human-inspired"\np = [0]\nsweep = "tremble?p=0,0.5,1"\n', "utf-8")
    rows = asked(file, "--success", "0.9,0.5,0.1", *FEW)
    assert [(row["family"], row["detected"]) for row in rows[:2]] == [
        ("tremble p", "tremble?p=0.5"),
        ("tremble p", "tremble?p=1"),
    ]
    assert rows[1]["trials"]["measured"][-1]["power"] == 1


def test_how_many_persons_and_boxes_and_what_is_assumed(asked, lockprobe):
    words = ("--success", "0.3,0.7", "--studies", 10)
    rows = asked("--people", *words, "--persons", "20,60", "--boxes-each", 2, "--seed", 2)
    short = ("--success", "0.3,0.7", "--studies", 1, "--persons", "20")
    assert "chosen by eye" in lockprobe("power", "--people", *short)[1]
    assert [(row["design"], row["boxes"], row["sd"]) for row in rows] == [
        (f"{design} persons", 4, sd) for design in ("within", "between") for sd in (0.5, 1, 1.5)
    ]
    assert all(row["persons"]["measured"][1]["power"] > 0.5 for row in rows)
    rows = asked("--over-boxes", "5,20", *words, "--trials", "1,5")
    (few, many), (_, most) = (row["boxes"]["measured"] for row in rows)
    assert (few["n"], many["n"], rows[1]["trials on each box"]) == (5, 20, 5)
    assert few["power"] <= 0.3 < many["power"] <= most["power"]
