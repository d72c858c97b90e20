"""Tidy rows, one a step or one a trial, have the promised columns, and the truth of every cell."""

import csv
import io
import json
import re
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

import lockprobe
from lockprobe.interfaces.export import COLUMNS, TRIAL_COLUMNS, tidy, tidy_rows, trial_rows
from lockprobe.interfaces.export.table_files import rows_of, write_rows, write_table


def written(trials, kind):
    file = io.StringIO()
    write_rows(rows_of("steps", trials), file, kind)
    return file.getvalue()


PROMISED = (
    "key, agent, box, modality, p, repetition, trial, step, joint, label, moved, told, claimed, misread, state, target, "
    "ending, reply"
)


def test_columns_are_those_promised():
    assert ", ".join(COLUMNS) == PROMISED
    assert all(tuple(row) == COLUMNS for row in tidy_rows(play_study(small_study())))


def test_rows_by_hand():
    trial = make_trial(SOLUTION, p=0.4, false_at=[2], claims=[None, "moved", "moved", "blocked"])
    first, *later = trial.steps
    replied = replace(first, decision=replace(first.decision, replies=("?", '=1+1 {"joint": "D"}')))
    trial = replace(trial, steps=(replied, *later))
    rows = list(tidy_rows([trial]))
    assert [row["step"] for row in rows] == [1, 2, 3, 4]
    assert [row["joint"] for row in rows] == ["revolute-right", "slider-2", "slider-1", "revolute-left"]
    assert [row["moved"] for row in rows] == [1, 1, 1, 1]
    assert [row["label"] for row in rows] == ["D", "C", "B", "A"]
    assert [row["told"] for row in rows] == [1, 0, 1, 1]
    assert [row["claimed"] for row in rows] == [1, 1, 0, ""]
    assert [row["misread"] for row in rows] == [0, 1, 1, ""]
    assert sum(row["misread"] or 0 for row in rows) == next(trial_rows([trial]))["misinterpretations"] == 2
    assert [row["reply"] for row in rows] == ['=1+1 {"joint": "D"}', "", "", ""]
    assert "\"'=1+1 {" in written([trial], "csv")
    assert [row["state"] for row in rows] == ["0000", "0001", "0011", "0111"]
    assert [row["target"] for row in rows] == [0, 0, 0, 1]
    assert {row["ending"] for row in rows} == {"solved"}


def test_where_panels_differ_each_row_names_its_own():
    trials = play_study(replace(small_study(), layout="shuffled"))
    assert len({trial.joints for trial in trials}) > 1
    rows = list(tidy_rows(trials))
    assert all(tuple(row) == (*COLUMNS, "panel") for row in rows)
    for row in rows:
        assert sorted(row["panel"].split()) == sorted(trials[0].joints)
        assert len(row["state"]) == len(row["panel"].split())
    assert written(trials, "csv").splitlines()[0] == PROMISED.replace(", ", ",") + ",panel"


def test_a_blocked_target_is_not_the_row_that_moved_it():
    assert [row["target"] for row in tidy_rows([make_trial([0, 0])])] == [0, 0]


def test_csv_and_jsonl_hold_the_same():
    trials = [*play_study(small_study(trials=1)), make_trial([], broken="model")]
    from_csv = list(csv.DictReader(io.StringIO(written(trials, "csv"))))
    from_jsonl = [json.loads(line) for line in written(trials, "jsonl").splitlines()]
    assert from_jsonl[0]["state"] == "0000"
    as_text = [{name: str(cell) for name, cell in row.items()} for row in from_jsonl]
    assert from_csv == [row | {"state": f"b{row['state']}"} for row in as_text]
    assert len(from_csv) == sum(len(trial.steps) for trial in trials)
    assert from_csv[0]["state"] == "b0000"


def test_where_two_readings_have_one_flip_rate_each_row_names_its_condition():
    planned = lockprobe.study("flips", agent="random", p=[0, 0.4], readings="fresh,kept", trials=1, repetitions=1)
    for rows in (tidy_rows, trial_rows):
        found = {(row["p"], row["condition"]) for row in rows(play_study(planned))}
        assert found == {(0.0, "truth"), (0.4, "flip?p=0.4"), (0.4, "flip?p=0.4&others=kept")}
    assert not any("condition" in row for row in trial_rows(play_study(small_study())))


def test_where_a_robot_played_its_verdict_comes_last():
    robot = make_trial([3, 0], budget=2, verdicts=["moved", "failed"])
    rows = list(tidy_rows([robot, make_trial([1])]))
    assert all(tuple(row) == (*COLUMNS, "verdict") for row in rows)
    assert [row["verdict"] for row in rows] == ["moved", "failed", ""]
    assert written([robot], "csv").splitlines()[0] == PROMISED.replace(", ", ",") + ",verdict"


def test_where_a_camera_was_read_its_positions_come_after_the_verdict():
    robot = make_trial([3, 0], budget=2, verdicts=["moved", "failed"], readings=["0000", "0001", "0?01"])
    rows = list(tidy_rows([robot, make_trial([1])]))
    assert [row["camera"] for row in rows] == ["0001", "0?01", ""]
    lines = written([robot, make_trial([1])], "csv").splitlines()
    assert lines[0].endswith(",verdict,camera")
    assert [line.rpartition(",")[2] for line in lines[1:]] == ["b0001", "b0?01", ""]


def test_parquet_keeps_types_and_leading_zeros(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    trials = [*play_study(small_study(trials=1)), make_trial([], broken="model")]
    write_table(rows_of("steps", trials), tmp_path / "x.parquet", "parquet")
    table = parquet.read_table(tmp_path / "x.parquet")
    missing = {"told", "claimed", "misread"}  # of an integer, which an empty text is not
    rows = [{k: None if k in missing and cell == "" else cell for k, cell in row.items()} for row in tidy_rows(trials)]
    assert table.to_pylist() == rows
    kinds = {field.name: str(field.type) for field in table.schema}
    assert (kinds["state"], kinds["p"], kinds["step"], kinds["moved"]) == ("string", "double", "int64", "int64")


def test_parquet_of_nothing_has_all_columns(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_table(rows_of("steps", []), tmp_path / "x.parquet", "parquet")
    assert tuple(parquet.read_table(tmp_path / "x.parquet").column_names) == COLUMNS


def test_what_steers_a_terminal_reaches_no_row():
    trial = replace(make_trial(SOLUTION), agent="x\x1b[2J\u202ey", key="flips/x\x07/truth/rep=1/trial=1")
    for text in (written([trial], "csv"), written([trial], "jsonl")):
        assert not {"\x1b", "\x07", "\u202e", "\\u202e", "\\u001b"} & set(re.findall(r"\\u....|.", text))
        assert "x?[2J?y" in text


def test_a_table_of_one_trial_or_several_is_at_hand():
    first, second = play_study(small_study())[:2]
    assert tidy([first, second]) == [*tidy(first), *tidy(second)]
    assert lockprobe.tidy is tidy


def test_rows_of_trials_by_hand():
    solved = make_trial(SOLUTION, p=0.4, false_at=[2], claims=[None, "moved", "moved", "moved"])
    looping = make_trial([0, 0, 0, 0, 0, 0])
    broken = make_trial([], broken="model")
    rows = list(trial_rows([solved, looping, broken]))
    assert all(tuple(row) == TRIAL_COLUMNS for row in rows)
    found = [
        (row["ending"], row["solved"], row["steps"], row["moves"], row["false_reports"], row["claims"],
         row["misinterpretations"], row["any_loop"], row["loop_coverage"], row["error"])
        for row in rows
    ]  # fmt: skip
    assert found == [
        ("solved", 1, 4, 4, 1, 3, 1, 0, 0.0, ""),
        (looping.ending, 0, 6, 0, 0, 0, 0, 1, 1.0, ""),
        ("error", "", 0, 0, 0, 0, 0, 0, "", "model"),
    ]
