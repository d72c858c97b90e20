"""Misinterpretations: the paper's Table 1 and its corrected companion."""

import pytest
from builders import SOLUTION, make_trial, modality_study, small_study
from page_parts import part
from reported import found_in

from lockprobe.foundation.formatting import NONE
from lockprobe.report.page import page_of, tables_of


def part_of(found):
    return part(page_of(found), "misinterpretations")


def test_table_1_is_laid_out_as_in_the_paper(tmp_path, modal):
    found = found_in(tmp_path, modality_study(), modal)
    table, corrected = (tables_of(found)[name] for name in ("table1", "table1-corrected"))
    assert table[0] == [
        "Input Modality", "Average State Misinterpretation Rate per Trial", "Total State Misinterpretations",
    ]  # fmt: skip
    assert [row[0] for row in table[1:]] == [
        "viewer (RGB)",
        "viewer (RGB-D)",
        "viewer (positions and outcomes in words)",
    ]
    assert [row[2] for row in table[1:]] == ["10, in 10 of 10 trials", "30, in 10 of 10 trials", "4, in 4 of 10 trials"]
    assert [row[0] for row in corrected[1:]] == [row[0] for row in table[1:]]
    details = part_of(found)
    assert "30, in 10 of 10 trials" in details
    assert "or what the pictures showed" in details
    assert "baselines are excluded" in part_of(found)


def test_claims_are_held_against_reports_and_against_the_truth(tmp_path):
    """Two claims of each trial contradict the report, one of a step with a false report; another one believes it."""
    trials = [
        make_trial((0, 0, *SOLUTION), agent="llm:local", trial=i, p=0.4, false_at=(1, 2),
                   claims=[None, "moved", "blocked", "blocked", "moved", "moved"])
        for i in (1, 2, 3)
    ]  # fmt: skip
    found = found_in(tmp_path, small_study(("llm:local",), (0.4,), 1, 3), trials)
    (cell,) = found.cells
    counts = {
        name: (row.count, row.n)
        for name in (
            "misread",
            "false_report",
            "false_belief",
            "false_reports_believed",
            "trials_with_misinterpretation",
        )
        if (row := cell.get(name))
    }
    assert counts == {
        "misread": (6, 15),
        "false_report": (6, 15),
        "false_belief": (6, 15),
        "false_reports_believed": (3, 6),
        "trials_with_misinterpretation": (3, 3),
    }
    assert cell.get("false_report", "steps").n == 18
    assert cell.value("misinterpretation_rate") == pytest.approx(0.4)
    assert sum(row.value for row in found.where("claims")) == 15
    head, row = tables_of(found)["table1-corrected"]
    said = dict(zip(head, row, strict=True))
    assert said["agent and condition"] == "llm:local, flip rate 0.4"
    assert said["false reports believed"] == "3 of 6"


LOW = "viewer:human-inspired?acuity=10"


def reading(agent, misread, modality="rgb"):
    """Three trials of three claims about failures and three about moves; the first few claims are wrong."""
    claims = [None, *(["moved"] * misread), *(["blocked"] * (2 - misread)), *["moved"] * 3]
    return [
        make_trial((0, 0, *SOLUTION), agent=agent, modality=modality, study="modalities", trial=i, claims=claims)
        for i in (1, 2, 3)
    ]


def test_what_the_viewer_misreads_stands_beside_every_other_agent_under_the_same_pictures(tmp_path):
    planned = modality_study(("random", "viewer", LOW), ("rgb", "symbolic"), trials=3)
    low = reading(LOW, 2)
    in_words = [*reading("viewer", 0, "symbolic"), *reading(LOW, 0, "symbolic")]
    found = found_in(tmp_path, planned, [*reading("viewer", 1), *low, *in_words])
    (row,), (pooled,) = found.where("misreading_floor"), found.where("floor_of_pictures")
    assert (row.agent, row.condition, row.count, row.n, row.clusters) == (LOW, "rgb", 3, 15, 3)
    assert (pooled.agent, pooled.count, pooled.n, pooled.clusters) == ("viewer", 3, 15, 3)
    assert row.low < row.value < row.high
    head, *rows = tables_of(found)["table1-corrected"]
    assert {line[0]: line[head.index("floor")].partition(" [")[0] for line in rows} == {
        "viewer (RGB)": NONE,
        f"{LOW} (RGB)": "20 %",
        "viewer (positions and outcomes in words)": NONE,
        f"{LOW} (positions and outcomes in words)": NONE,
    }
    assert "the scripted viewer misread 20 %" in part_of(found)
    alone = found_in(tmp_path / "alone", modality_study((LOW,), ("rgb",), trials=3), low)
    assert "floor" not in tables_of(alone)["table1-corrected"][0]
    assert "--agent viewer adds a scripted reader" in part_of(alone)
    not_yet = found_in(tmp_path / "not-yet", modality_study(("viewer", LOW), ("rgb",), trials=3), low)
    assert not_yet.said("misinterpretations", "floor") == []


def test_false_pictures_are_not_part_of_the_floor(tmp_path):
    """The floor is of reading: a viewer that reads what a false picture shows misreads nothing."""
    planned = modality_study(("viewer", LOW), ("rgb?p=0.4",), trials=1)
    trials = [
        make_trial((0, 0, *SOLUTION), agent=agent, modality="rgb?p=0.4", study="modalities", false_at=(1,), claims=said)
        for agent, said in (("viewer", [None, "moved", "blocked"]), (LOW, [None, "blocked", "blocked"]))
    ]
    row = found_in(tmp_path, planned, trials).one("misreading_floor")
    assert (row.agent, row.count, row.n) == (LOW, 0, 2)
