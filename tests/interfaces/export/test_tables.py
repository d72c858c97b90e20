"""What people did stands in the tables once, and what was left is no failure."""

import csv
import io
import json
from dataclasses import replace

import pytest
from builders import play_study, small_study, write_study
from stored import acts, rewrite_acts
from taking_part import START, take_part

from lockprobe.interfaces.export import tidy_rows, trial_rows
from lockprobe.interfaces.export.table_files import write_rows, write_table
from lockprobe.interfaces.export.tables import TABLES, PeopleRecords, people_table, table_of
from lockprobe.people.diary import Answers, Diary, Did, Released, read_diaries, write_diaries
from lockprobe.people.experiment import Experiment
from lockprobe.studies.records.store import written as opened

STUDY = small_study(["random", "participant"], p=[0.0, 0.4], trials=2)
ANN, BOB, CEM = "aaaa01", "bbbb02", "cccc03"


@pytest.fixture
def directory(tmp_path):
    (tmp_path / "people").mkdir()
    return write_study(tmp_path, STUDY, play_study(replace(STUDY, agents=("random",))))


def tables(directory):
    records = PeopleRecords.read(directory, platform_ids=True)
    return {name: people_table(records, name) for name in TABLES if name != "calls"}


def test_steps_are_the_tidy_steps_with_what_only_people_have(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)])
    records = PeopleRecords.read(directory)
    steps = tables(directory)["steps"]
    tidy = list(tidy_rows(records.trials))
    assert [{name: row[name] for name in tidy[0]} for row in steps.rows] == tidy
    ours = [row for row in steps.rows if row["participant"] == ANN]
    assert [row["position"] for row in ours] == sorted(row["position"] for row in ours)
    assert {row["view"] for row in ours} == {"panel"}
    assert all(row["rt_ms"] == 1000.5 + row["step"] and row["report"] for row in ours)
    assert [row["claimed_rt_ms"] for row in ours] == ["" if row["claimed"] == "" else 300.25 for row in ours]
    others = [row for row in steps.rows if row["agent"] == "random"]
    assert others
    assert all(row["participant"] == row["rt_ms"] == "" and row["position"] == "" for row in others)


def test_who_left_is_in_the_acts_and_in_no_step(directory):
    take_part(directory, STUDY, BOB, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1)
    found = tables(directory)
    left = "flips/participant/flip?p=0.4/rep=2/trial=1"
    assert left not in {row["key"] for row in found["steps"].rows}
    assert [
        (row["position"], row["step"], row["recorded"]) for row in found["acts"].rows if row.get("key") == left
    ] == [(2, 1, 0)]
    (row,) = found["participants"].rows
    assert (row["boxes_assigned"], row["boxes_finished"], row["left_in_box"], row["left_after_step"]) == (2, 1, 2, 1)


@pytest.mark.parametrize(("after", "box"), [(0, 0), (1, 1)])
def test_who_left_before_a_step_in_any_box_left_in_none(directory, after, box):
    take_part(directory, STUDY, BOB, [(0.0, 1, 1)], left_after=after)
    (row,) = tables(directory)["participants"].rows
    assert (row["left_in_box"], row["left_after_step"]) == (box, after)


def test_every_act_is_a_row_and_says_whether_its_step_is_recorded(directory):
    trials = take_part(directory, STUDY, ANN, [(0.4, 1, 1)])
    found = tables(directory)["acts"]
    assert [row["turn"] for row in found.rows] == list(range(2, len(found.rows) + 2))
    assert sum(row["recorded"] or 0 for row in found.rows) == len(trials[0].steps)
    practice = [row for row in found.rows if row.get("position") == 0 and row["scene"] == "box"]
    assert [(row["key"], row["recorded"], row["label"], row["ended"]) for row in practice] == [("", 0, "A", "solved")]
    assert all(row["rt_ms"] == "" for row in found.rows if row["scene"] in ("page", "over"))


def test_participants_with_what_was_read_and_how_their_checks_went(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=True)
    take_part(directory, STUDY, BOB, [(0.4, 1, 2)], check=False)
    take_part(directory, STUDY, CEM, [(0.4, 2, 2)], check=None)
    rows = {row["participant"]: row for row in tables(directory)["participants"].rows}
    assert {name: (row["checks_right"], row["checks_wrong"]) for name, row in rows.items()} == {
        ANN: (1, 0),
        BOB: (0, 1),
        CEM: (0, 0),
    }
    assert all((row["language"], row["texts"]) == ("en", "3f9a01bc22d1") for row in rows.values())
    assert all(row["left_in_box"] == "" for row in rows.values())


def test_checks_and_answers_stand_with_their_questions(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=False, answers={"why": "because"})
    asked = {
        "checks": [{"after": 1, "question": "Blue, please.", "options": ["red", "blue"], "right": "blue"}],
        "questions": [{"name": "why", "question": "Why?"}],
    }
    (directory / "people" / "experiment.json").write_text(json.dumps(asked))
    found = tables(directory)
    (check,), (answer,) = found["checks"].rows, found["answers"].rows
    assert (check["check"], check["question"], check["answer"], check["right"]) == (1, "Blue, please.", "red", 0)
    assert (answer["name"], answer["question"], answer["answer"]) == ("why", "Why?", "because")
    assert PeopleRecords.read(directory).experiment == Experiment.model_validate(asked)


def test_trials_are_those_of_the_export_with_who_played_them(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)])
    records = PeopleRecords.read(directory)
    trials = tables(directory)["trials"]
    plain = list(trial_rows(records.trials))
    assert [{name: row[name] for name in plain[0]} for row in trials.rows] == plain
    ours = [row for row in trials.rows if row["participant"]]
    assert [(row["participant"], row["position"], row["view"]) for row in ours] == [
        (ANN, 1, "panel"), (ANN, 2, "panel")
    ]  # fmt: skip


def test_a_participant_has_conditions_a_device_and_an_end(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], answers={"why": ""})
    take_part(directory, STUDY, BOB, [(0.0, 1, 1)])
    take_part(directory, STUDY, CEM, [(0.0, 2, 1), (0.4, 2, 2)], left_after=1)
    lines = acts(directory, ANN)
    for number, line in enumerate(line for line in lines if "pointer" in line.get("act", {})):
        device = ("touch", [390, 844]) if number < 2 else ("mouse", [1280, 800])
        line["act"] |= zip(("pointer", "viewport"), device, strict=True)
    rewrite_acts(directory, ANN, lines)
    rows = {row["participant"]: row for row in tables(directory)["participants"].rows}
    assert [row["conditions"] for row in rows.values()] == [
        "flip?p=0.4; truth",
        "truth",
        "truth; flip?p=0.4",
    ]
    assert {name: row["finished"] for name, row in rows.items()} == {ANN: 1, BOB: 1, CEM: 0}
    device = ("pointers", "window_width", "window_height")
    assert [rows[ANN][name] for name in device] == ["mouse touch", 390, 844]
    assert [rows[BOB][name] for name in device] == ["", "", ""]
    (directory / "people" / "experiment.json").write_text(json.dumps({"questions": [{"name": "why", "question": "?"}]}))
    rows = {row["participant"]: row for row in tables(directory)["participants"].rows}
    assert {name: row["finished"] for name, row in rows.items()} == {ANN: 1, BOB: 1, CEM: 0}
    assert [rows[name]["questions_left"] for name in (ANN, BOB)] == [0, 1]  # who closed at the questions has played


def test_a_box_that_broke_is_neither_finished_nor_left(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=0)
    lines = acts(directory, ANN)
    broken = {"kind": "broken", "at": 1790000900.0, "turn": len(lines) + 1, "box": 2}
    rewrite_acts(directory, ANN, [*lines, broken, {"kind": "released", "at": 1790000999.0}])
    found = tables(directory)
    (row,) = found["participants"].rows
    assert (row["boxes_finished"], row["boxes_broken"], row["released"], row["left_in_box"]) == (1, 1, 1, "")
    last = found["acts"].rows[-1]
    assert (last["scene"], last["position"], last["turn"]) == ("broken", 2, broken["turn"])


@pytest.mark.parametrize(
    ("said", "written"),
    [
        ("=1+1", "'=1+1"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("-cmd", "'-cmd"),
        ("\t=1", "'\t=1"),
        ("-3.5", "-3.5"),
        ("+4", "+4"),
        ("a=1", "a=1"),
        ("", ""),
    ],
)
def test_no_answer_is_a_formula(directory, said, written):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], answers={"why": said}, platform={"PID": said})
    for name, cell in (("answers", "answer"), ("participants", "platform_PID")):
        table, file = tables(directory)[name], io.StringIO()
        write_rows(table, file, "csv")
        (row,) = csv.DictReader(io.StringIO(file.getvalue()))
        assert (table.rows[0][cell], row[cell]) == (said, written)


def test_participants_have_how_long_they_took_for_all_and_for_each_box(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 1)])
    found = tables(directory)
    (row,) = found["participants"].rows
    each = [float(seconds) for seconds in row["box_seconds"].split("; ")]
    at = [act["at"] for act in found["acts"].rows if act.get("at") is not None]
    assert len(each) == 2
    assert all(seconds > 0 for seconds in each)
    assert sum(each) <= max(at) - min(at) <= row["seconds"]
    mine = [row for row in found["trials"].rows if row["participant"] == ANN]
    assert [round(one["trial_seconds"], 1) for one in sorted(mine, key=lambda one: one["position"])] == each


def test_rounds_of_questions_on_the_instructions_are_counted_and_who_was_screened_out_is_marked(directory):
    take_part(directory, STUDY, BOB, [(0.4, 1, 1)])
    (bob,) = read_diaries(directory)
    joined = bob.joined.model_copy(update={"identity": ANN})
    rounds = [
        Did(
            at=joined.at + n,
            turn=n + 1,
            scene="comprehension",
            act=Answers(answers=("a",), rt=9.5),
            item=str(n),
            right=False,
        )
        for n in (1, 2)
    ]
    with opened(directory) as store:
        write_diaries(store, [Diary(joined, (*rounds, Released(at=joined.at + 3, why="screened")))])
    found = tables(directory)
    row, other = sorted(found["participants"].rows, key=lambda row: row["participant"])
    assert (other["comprehension_rounds"], other["screened"], other["finished"]) == ("", 0, 1)
    assert (row["comprehension_rounds"], row["screened"], row["released"], row["finished"]) == (2, 1, 0, 0)
    assert (row["left_in_box"], row["left_after_step"]) == (0, 0)
    mine = [act for act in found["acts"].rows if act["participant"] == ANN]
    assert [(act["scene"], act["rt_ms"]) for act in mine] == [("comprehension", 9.5)] * 2


@pytest.mark.parametrize("kind", ["csv", "jsonl", "parquet"])
def test_every_table_is_written_and_none_says_who_or_when(directory, tmp_path, kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    platform = {"PROLIFIC_PID": "5f00ab"}
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=True, answers={"why": "one\rtwo"}, platform=platform)
    take_part(directory, STUDY, BOB, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1)
    (out := tmp_path / "out").mkdir()
    for name in TABLES:
        path, beside = write_table(table_of(directory, name), out / f"{name}.{kind}", kind)
        for secret in ("5f00ab", "f" * 64, str(int(START))[:6]):
            assert secret.encode() not in path.read_bytes() + beside.read_bytes()
    path, _ = write_table(table_of(directory, "participants", platform_ids=True), out / f"with.{kind}", kind)
    assert b"5f00ab" in path.read_bytes()
