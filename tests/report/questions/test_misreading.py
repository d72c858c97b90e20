"""Misreading: the paper's Table 1, counted by hand, and how often reports were false."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, modality_study, small_study
from page_parts import part
from reported import found_in

from lockprobe.report.page import Page, tables_of


def test_table_1_has_a_row_for_each_modality(tmp_path, modal):
    found = found_in(tmp_path, modality_study(), modal)
    head, *rows = tables_of(found)["table1"]
    assert head[:3] == ["agent", "modality", "claims"]
    assert [(row[1], *row[-2:]) for row in rows] == [
        ("RGB", "10", "10 of 10"),
        ("RGB-D", "30", "10 of 10"),
        ("positions and outcomes in words", "4", "4 of 10"),
    ]
    assert "Table 1" in part(Page(found=found).text(), "misreading")


def test_claims_are_held_against_reports_and_against_the_truth(tmp_path):
    """Two claims of each trial contradict the report, one of a step with a false report; another one believes it."""
    trials = [
        make_trial((0, 0, *SOLUTION), agent="llm:local", trial=i, p=0.4, false_at=(1, 2),
                   claims=[None, "moved", "blocked", "blocked", "moved", "moved"])
        for i in (1, 2, 3)
    ]  # fmt: skip
    found = found_in(tmp_path, small_study(("llm:local",), (0.4,), 1, 3), trials)
    (cell,) = found.cells
    rows = map(cell.get, ("misread", "false_report", "false_belief"))
    assert {(row.count, row.n, row.clusters) for row in rows} == {(6, 15, 3)}
    parts = cell.get("misread", "said moved"), cell.get("misinterpretations", "trials with any")
    assert [(row.count, row.n, row.clusters) for row in parts] == [(0, 6, 3), (3, 3, None)]
    assert cell.get("false_report", "steps").n == 18
    assert cell.value("misinterpretations") == 6
    assert tables_of(found)["table1"][1] == ["llm:local", "0.4", "15", cell_of(cell), "40.0 %", "0.0 %", "6", "3 of 3"]


def cell_of(cell):
    row = cell.get("misread")
    return f"40 % [{100 * row.low:.0f}, {100 * row.high:.0f}]"


def test_the_rate_is_the_mean_over_trials_and_misread_is_pooled_over_claims(tmp_path):
    """One claim of one is misread, and none of three; agents that were not asked have no row."""
    said = ([None, "moved", None, None], [None, *["blocked"] * 3])
    trials = [make_trial((0,) * 4, agent="llm:a", claims=one, trial=i, budget=4) for i, one in enumerate(said, 1)]
    silent = [make_trial((0,) * 4, agent="llm:b", trial=i, budget=4) for i in (1, 2)]
    planned = replace(small_study(("llm:a", "llm:b"), (0.0,), 1, 2), max_steps=4)
    found = found_in(tmp_path, planned, [*trials, *silent])
    (cell,) = (one for one in found.cells if one.get("misread"))
    assert cell.value("misread") == 0.25
    assert cell.value("misinterpretations", "rate") == 0.5
    assert cell.value("misinterpretations", "SD of rates") == pytest.approx(0.5**0.5)
    assert "25 % of claims contradict the report" in Page(found=found).text()
    assert part(Page(found=found_in(tmp_path / "b", planned, silent)).text(), "misreading") == ""
