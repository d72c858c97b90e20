"""One report for every design: a condition beside flips adds to it, takes nothing away, and changes no P value."""

import json

import pytest
from builders import write_study

from lockprobe.report import write_report
from lockprobe.report.results import results
from lockprobe.studies.studyfile import study

SMALL = {"agent": ["cognitive:perseverant", "human-inspired"], "trials": 8, "repetitions": 2, "seed": 5}
FLIPS = {"p": [0, 0.4, 0.8]}
BESIDE = [
    {"condition": ["nudge"]},
    {"sweep": "tremble?p=0.2,0.5"},
    {"condition": ["flip?p=0.4&persistence=sticky", "drop?p=0.5 + flip?p=0.4"]},
]
OF_FLIPS = ("contrasts", "tests", "fits", "courses", "leaderboard", "comparisons", "interactions", "paces", "lies")


def played(directory, **asked):
    return write_study(directory, study("flips", **SMALL, **asked))


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return played(tmp_path_factory.mktemp("alone") / "study", **FLIPS)


@pytest.mark.parametrize("more", BESIDE, ids=["a condition", "a dose", "other flips"])
def test_other_conditions_change_no_number_of_flips(alone, more, tmp_path):
    before, now = results(alone).plain(), results(played(tmp_path / "study", **FLIPS, **more)).plain()
    assert before.keys() < now.keys()
    for name in OF_FLIPS:
        assert now[name] == before[name], name
    rows = {row["key"]: row | {"acts": None} for row in now["conditions"]}
    for row in before["conditions"]:
        assert rows[row["key"]] == row | {"acts": None}
    axis = {row["condition"] for row in before["conditions"]}
    assert axis < {row["condition"] for row in now["conditions"]}


@pytest.mark.parametrize("p", [[0, 0.4], [0, 0.1, 0.2, 0.9]], ids=str)
def test_flips_change_no_p_value_of_other_conditions(p, tmp_path):
    others = {"condition": ["nudge", "drop?p=0.5", "tremble?p=0.5"]}
    without = results(played(tmp_path / "without", p=[0], **others)).plain()["effects"]
    beside = results(played(tmp_path / "beside", p=p, **others)).plain()["effects"]
    assert [row for row in beside if not row["condition"].startswith("flip")] == without
    flips = [row for row in beside if row["condition"].startswith("flip")]
    assert {row["corrected_for"] for row in flips} == {len(p) - 1}
    assert {row["corrected_for"] for row in without} == {3}


def test_every_contrast_with_the_control_stands_in_one_table_with_the_p_value_of_its_family(alone, tmp_path):
    found = results(played(tmp_path / "study", **FLIPS, **BESIDE[0])).plain()
    both = {(row["agent"], row["condition"]): row["p_value"] for row in found["effects"]}
    assert len(both) == len(found["effects"]) == 2 * 3
    for row in found["contrasts"]:
        assert both[row["agent"], f"flip?p={row['other_p']:g}"] == row["p_value"]


def test_page_tables_and_figures_hold_all_that_flips_alone_have(alone, tmp_path):
    beside = played(tmp_path / "study", **FLIPS, **BESIDE[0])
    for directory in (alone, beside):
        write_report(directory)
    for folder in ("tables", "figures"):
        before, now = ({path.name for path in (one / folder).iterdir()} for one in (alone, beside))
        assert before < now
    before, now = ((one / "report.html").read_text() for one in (alone, beside))
    for heading in ("Agents compared", "Success and false reports", "Speed", "Optimal actions", "Action loops",
                    "Effect of one false report", "Hypothesis tests", "Misinterpretations", "All conditions"):  # fmt: skip
        assert f"{heading}</" in before, heading
        assert f"{heading}</" in now, heading
    assert "Every condition against the control</" in now
    assert "Every condition against the control</" not in before
    speed = (beside / "tables" / "speed.csv").read_text()
    assert "cognitive:perseverant,nudge" in speed
    heads = [(one / "tables" / "speed.csv").read_text().split(",")[1] for one in (alone, beside)]
    assert heads == ["p", "condition"]


def test_conditions_without_flips_have_speed_loops_and_agents_compared(tmp_path):
    directory = played(tmp_path / "study", p=[0], condition=["nudge"], sweep="tremble?p=0.2,0.5")
    write_report(directory)
    found = json.loads((directory / "results.json").read_text())
    assert found["comparisons"]
    labels = {"truth", "nudge", "tremble?p=0.2", "tremble?p=0.5"}
    assert {row["condition"] for row in found["detectors"]} == labels
    assert {row["condition"] for row in found["rationality"]} >= {
        "truth",
        "nudge",
    }  # a trembling hand is not the choice
    for name in ("speed", "loops", "detectors"):
        assert "tremble?p=0.5" in (directory / "tables" / f"{name}.csv").read_text()


def test_an_idle_condition_takes_no_answer_on_flips_away(tmp_path):
    beside = results(played(tmp_path / "study", **FLIPS, condition=["history?last=50"])).plain()
    alone = results(played(tmp_path / "alone", **FLIPS)).plain()
    assert beside["overview"]["answer"] == alone["overview"]["answer"]
    assert "history?last=50 changed nothing" in beside["overview"]["changed_nothing"]


def test_flips_of_another_kind_are_told_apart_in_every_table(tmp_path):
    directory = played(tmp_path / "study", p=[0, 0.4], flip="sticky", condition=["flip?p=0.4", "flip?p=0.1"])
    write_report(directory)
    found = json.loads((directory / "results.json").read_text())
    assert found["flips"]["kind"] == "sticky"
    assert {row["other_p"] for row in found["contrasts"]} == {0.4}
    for name in ("speed", "loops", "detectors"):
        rows = [line.split(",")[:2] for line in (directory / "tables" / f"{name}.csv").read_text().splitlines()]
        assert len({tuple(row) for row in rows}) == len(rows), name


def test_no_other_condition_is_spoken_of_where_agents_play_alike(tmp_path):
    planned = study("flips", agent=["round-robin"], p=[0, 0.4], condition=["tremble?p=0.9"], trials=6, repetitions=1)
    answer = results(write_study(tmp_path / "study", planned)).plain()["overview"]["answer"]
    assert "at every flip rate" in answer
    assert "under every condition" not in answer
