"""Tables have the truth of every cell, say what stands in each column, and come back from every kind of file."""

import csv
import io
import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study
from stored import acts, rewrite_acts
from stored import written as opened
from taking_part import START, take_part

import lockprobe
from lockprobe.interfaces import export
from lockprobe.interfaces.export import Table, TableName, steps_table, table_of, tidy, trial_rows, trials_table
from lockprobe.people.diary import Answers, Did, read_diaries, write_entry

STUDY = small_study(["random", "participant"], p=[0.0, 0.4], trials=2)
TABLES = get_args(TableName)
ANN, BOB, CEM = "aaaa01", "bbbb02", "cccc03"
DOCS = Path(__file__).parents[2] / "docs"
COLUMNS_FILE = Path(export.__file__).with_name("columns.toml")
MARK, COUNT, TEXT = (
    {"base": "integer", "minimum": 0, "maximum": 1},
    {"base": "integer", "minimum": 1},
    {"base": "string"},
)
KINDS = {
    "moved": MARK,
    "solved": MARK,
    "step": COUNT,
    "budget": COUNT,
    "joint": TEXT,
    "state": TEXT,
    "p": {"base": "number", "minimum": 0, "maximum": 1},
}
FEW = ("reply", "chosen", "verdict", "camera")
COLUMNS = [
    "key", "agent", "box", "modality", "condition", "p", "repetition", "trial", "step", "joint", "label", "moved",
    "told_moved", "claimed", "misread", "state", "target", "ending", "panel",
]  # fmt: skip


@pytest.fixture
def directory(tmp_path):
    (tmp_path / "people").mkdir()
    return write_study(tmp_path, STUDY, play_study(replace(STUDY, agents=("random",))))


def rows(directory, name, **more):
    return list(table_of(directory, name, **more).rows())


def written(table, kind):
    file = io.StringIO()
    table.write_text(file, kind)
    return file.getvalue()


def column(found, name):
    return [row[name] for row in found]


def test_steps_by_hand():
    trial = make_trial(SOLUTION, p=0.4, false_at=[2], claims=[None, "moved", "moved", "blocked"])
    first, *later = trial.steps
    replied = replace(first, decision=replace(first.decision, replies=("?", '=1+1 {"joint": "D"}')))
    trial = replace(trial, steps=(replied, *later))
    found = tidy(trial)
    assert [*found[0]] == [*COLUMNS, "reply"]
    assert column(found, "step") == [1, 2, 3, 4]
    assert column(found, "joint") == ["revolute-right", "slider-2", "slider-1", "revolute-left"]
    assert column(found, "label") == ["D", "C", "B", "A"]
    assert column(found, "moved") == [1, 1, 1, 1]
    assert column(found, "told_moved") == [1, 0, 1, 1]
    assert column(found, "claimed") == [1, 1, 0, ""]
    assert column(found, "misread") == [0, 1, 1, ""]
    assert column(found, "state") == ["0000", "0001", "0011", "0111"]
    assert column(found, "target") == [0, 0, 0, 1]
    assert set(column(found, "ending")) == {"solved"}
    assert column(found, "reply") == ['=1+1 {"joint": "D"}', "", "", ""]
    assert "\"'=1+1 {" in written(steps_table([trial]), "csv")
    assert column(tidy(make_trial([0, 0])), "target") == [0, 0]  # blocked


def test_trials_by_hand():
    solved = make_trial(SOLUTION, p=0.4, false_at=[2], claims=[None, "moved", "moved", "moved"])
    looping = make_trial([0, 0, 0, 0, 0, 0])
    found = trial_rows([solved, looping, make_trial([], broken="model")])
    names = [
        "ending", "solved", "steps", "moves", "false_reports", "claims", "misinterpretations", "any_loop",
        "loop_coverage", "error",
    ]  # fmt: skip
    assert [tuple(row[name] for name in names) for row in found] == [
        ("solved", 1, 4, 4, 1, 3, 1, 0, 0.0, ""),
        (looping.ending, 0, 6, 0, 0, 0, 0, 1, 1.0, ""),
        ("error", "", 0, 0, 0, 0, 0, 0, "", "model"),
    ]


def test_what_few_trials_have_comes_last_and_only_where_it_is():
    robot = make_trial([3, 0], budget=2, verdicts=["moved", "failed"], readings=["0000", "0001", "0?01"])
    found = tidy([robot, make_trial([1])])
    assert [*found[0]] == [*COLUMNS, "verdict", "camera"]
    assert column(found, "verdict") == ["moved", "failed", ""]
    assert column(found, "camera") == ["0001", "0?01", ""]
    assert [*tidy(make_trial([1]))[0]] == COLUMNS
    trials = play_study(replace(small_study(), layout="shuffled"))
    assert {row["panel"] for row in tidy(trials)} == {" ".join(trial.joints) for trial in trials if trial.steps}
    planned = lockprobe.study(
        "flips", agent="random", p=[0, 0.4], flip="re-observed,integrated", trials=1, repetitions=1
    )
    found = {(row["p"], row["condition"]) for row in trial_rows(play_study(planned))}
    assert found == {(0.0, "truth"), (0.4, "flip?p=0.4"), (0.4, "flip?p=0.4&others=kept")}


def test_every_kind_of_file_holds_the_same_beside_its_dictionary(tmp_path):
    trials = [*play_study(small_study(trials=1)), make_trial([], broken="model")]
    for table in (steps_table(trials), trials_table(trials)):
        found = list(table.rows())
        as_text = [{name: str(cell) for name, cell in row.items()} for row in found]
        bits = {"state": lambda row: f"b{row['state']}"} if "state" in found[0] else {}
        for kind in ("csv", "jsonl", "parquet"):
            path = tmp_path / f"x.{kind}"
            assert table.write(path, kind) == [path, tmp_path / f"x.{kind}-metadata.json"]
            said = json.loads((tmp_path / f"x.{kind}-metadata.json").read_text("utf-8"))
            described = {one["name"]: one for one in said["tableSchema"]["columns"]}
            assert (said["url"], [*described]) == (path.name, [*found[0]])
            assert all(described[name]["datatype"] == kind for name, kind in KINDS.items() if name in described)
            meanings = {name: one["dc:description"] for name, one in described.items()}
            assert all(meanings[name].endswith(one["meaning"]) for name, one in table.columns.items())
            if kind == "jsonl":
                assert [json.loads(line) for line in path.read_text("utf-8").splitlines()] == found
            elif kind == "csv":
                read = list(csv.DictReader(io.StringIO(path.read_bytes().decode(), newline="")))
                assert read == [row | {name: of(row) for name, of in bits.items()} for row in as_text]
            else:
                parquet = pytest.importorskip("pyarrow.parquet").read_table(path)
                numbers = {name for name, one in described.items() if one["datatype"]["base"] != "string"}
                missing = [{name: None if name in numbers and cell == "" else cell for name, cell in row.items()} for row in found]  # fmt: skip
                assert parquet.to_pylist() == missing
    assert written(steps_table([]), "csv").strip().split(",") == COLUMNS


def test_no_text_breaks_a_line_or_steers_a_terminal():
    trial = replace(make_trial(SOLUTION), agent="x\x1b[2J\u202ey", key="flips/x\x07/truth/rep=1/trial=1")
    for kind in ("csv", "jsonl"):
        found = written(steps_table([trial]), kind)
        assert not {"\x1b", "\x07", "\u202e", "\\u202e", "\\u001b"} & set(re.findall(r"\\u....|.", found))
        assert "x?[2J?y" in found
    for end in "\u2028\u2029\x85":
        key = rf"ключ{end}\{end}\u2028"
        (line,) = written(Table("calls", lambda key=key: [{"key": key}]), "jsonl").splitlines()
        assert json.loads(line)["key"] in (key, key.replace(end, "?"))
        assert "ключ" in line


def test_what_is_measured_has_a_unit_and_a_clock_and_the_docs_name_every_column_of_trials(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=True)
    tables = {name: table_of(directory, name) for name in TABLES}
    described = {name for part in tomllib.loads(COLUMNS_FILE.read_text("utf-8")).values() for name in part}
    for table in tables.values():
        for name, one in table.columns.items():
            assert one["meaning"].endswith(".")
            measured = name.endswith("_ms") or name in ("at", "seconds", "trial_seconds")
            assert not measured or (
                "clock" in one["meaning"] and one["unit"] in ("ms", "s") and one["kind"] == "number"
            )
        assert {name for row in table._rows() for name in row} <= described  # else it would be in no file
    page = (DOCS / "data.md").read_text("utf-8")
    of_people = {"view", "report", "shown", "at", "rt_ms", "claimed_rt_ms", "trial_seconds"}
    named = {*tables["steps"].columns, *tables["trials"].columns, *FEW} - of_people
    assert {name for name in named if f"`{name}`" not in page} == set()


def test_steps_and_trials_of_people_have_what_only_people_have(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)])
    steps, trials = rows(directory, "steps"), rows(directory, "trials")
    ours = [row for row in steps if row["participant"] == ANN]
    assert column(ours, "position") == sorted(column(ours, "position"))
    assert set(column(ours, "view")) == {"panel"}
    assert all(row["rt_ms"] == 1000.5 + row["step"] and row["report"] for row in ours)
    assert column(ours, "claimed_rt_ms") == ["" if row["claimed"] == "" else 300.25 for row in ours]
    others = [row for row in steps if row["agent"] == "random"]
    assert others
    assert all(row["participant"] == row["rt_ms"] == row["position"] == "" for row in others)
    played = [row for row in trials if row["participant"]]
    assert [(row["participant"], row["position"], row["view"]) for row in played] == [(ANN, 1, "panel"), (ANN, 2, "panel")]  # fmt: skip
    assert all(row["trial_seconds"] > 0 for row in played)
    for mine, plain in ((steps, tidy(lockprobe.load(directory))), (trials, trial_rows(lockprobe.load(directory)))):
        assert [{name: row[name] for name in one} for row, one in zip(mine, plain, strict=True)] == plain


@pytest.mark.parametrize(("after", "box"), [(None, ""), (0, 0), (1, 1)])
def test_who_left_is_in_the_acts_and_in_no_step(directory, after, box):
    take_part(directory, STUDY, BOB, [(0.0, 1, 1)], **({} if after is None else {"left_after": after}))
    (row,) = rows(directory, "participants")
    assert (row["boxes_assigned"], row["boxes_finished"], row["finished"]) == (1, box == "", box == "")
    assert (row["left_in_box"], row["left_after_step"]) == (box, "" if after is None else after)
    key = "flips/participant/truth/rep=1/trial=1"
    taken = [row["recorded"] for row in rows(directory, "acts") if row["key"] == key and row["label"]]
    assert (set(taken), bool(taken)) == ({int(box == "")} if after != 0 else set(), after != 0)
    assert (key in column(rows(directory, "trials"), "key")) == (box == "")


def test_every_act_is_a_row_and_says_whether_its_step_is_recorded(directory):
    trials = take_part(directory, STUDY, ANN, [(0.4, 1, 1)])
    lines = acts(directory, ANN)
    for line in lines:
        if "pointer" in line.get("act", {}):
            line["act"] |= {"pointer": "touch", "viewport": [390, 844]}
    rewrite_acts(directory, ANN, lines)
    found = rows(directory, "acts")
    assert column(found, "turn") == list(range(2, len(found) + 2))
    assert sum(row["recorded"] or 0 for row in found) == len(trials[0].steps)
    practice = [row for row in found if row["position"] == 0 and row["scene"] == "box"]
    names = ("key", "recorded", "label", "ended", "pointer", "window_width", "window_height")
    assert [tuple(row[name] for name in names) for row in practice] == [("", 0, "A", "solved", "touch", 390, 844)]
    assert all(row["rt_ms"] == 700 for row in found if row["scene"] in ("page", "over"))  # how long one read


def test_a_box_that_broke_is_neither_finished_nor_left(directory):
    take_part(directory, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=0)
    lines = acts(directory, ANN)
    broken = {"at": 1790000900.0, "turn": len(lines) + 1, "scene": "box", "act": None, "box": 2, "ended": "error"}
    late = {"at": 1790000999.0, "turn": len(lines) + 2, "scene": "late", "act": None}
    rewrite_acts(directory, ANN, [*lines, broken, late])
    (row,) = rows(directory, "participants")
    assert (row["boxes_finished"], row["boxes_broken"], row["released"], row["left_in_box"]) == (1, 1, 1, "")
    assert (row["seconds"], row["conditions"]) == (1.5 * len(lines), "flip?p=0.4; truth")  # to the last act
    last = rows(directory, "acts")[-1]
    assert (last["scene"], last["position"], last["turn"]) == ("broken", 2, broken["turn"])


def test_answers_stand_with_their_questions_and_none_is_a_formula(directory):
    said = {"=1+1": "'=1+1", "@SUM(A1)": "'@SUM(A1)", "-cmd": "'-cmd", "\t=1": "'\t=1", "-3.5": "-3.5", "+4": "+4"}
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=False, answers={f"q{i}": one for i, one in enumerate(said)})
    asked = {
        "checks": [{"after": 1, "question": "Blue, please.", "options": ["red", "blue"], "right": "blue"}],
        "questions": [{"name": "q0", "question": "Why?"}],
    }
    (directory / "people" / "experiment.json").write_text(json.dumps(asked))
    check, *found = rows(directory, "answers")
    names = ("scene", "name", "question", "answer", "right")
    assert [check[name] for name in names] == ["check", "1", "Blue, please.", "red", 0]
    assert [found[0][name] for name in names] == ["ask", "q0", "Why?", "=1+1", ""]
    read = list(csv.DictReader(io.StringIO(written(table_of(directory, "answers"), "csv"), newline="")))
    assert dict(zip(column(found, "answer"), column(read[1:], "answer"), strict=True)) == said


def test_rounds_of_questions_on_the_instructions_are_counted(directory):
    take_part(directory, STUDY, BOB, [(0.4, 1, 1)])
    (bob,) = read_diaries(directory)
    joined = bob.joined.model_copy(update={"identity": ANN})
    wrong = {"scene": "comprehension", "act": Answers(answers=("a",), rt=9.5), "right": False}
    rounds = [Did(at=joined.at + n, turn=n + 1, item=str(n), **wrong) for n in (1, 2)]
    with opened(directory) as store:
        for number, entry in enumerate((joined, *rounds), 1):
            write_entry(store, ANN, number, entry)
    row, other = sorted(rows(directory, "participants"), key=lambda row: row["participant"])
    assert (other["comprehension_rounds"], other["finished"]) == ("", 1)
    assert (row["comprehension_rounds"], row["released"], row["finished"]) == (2, 0, 0)
    assert (row["left_in_box"], row["left_after_step"]) == (0, 0)
    mine = [act for act in rows(directory, "acts") if act["participant"] == ANN]
    assert [(act["scene"], act["rt_ms"]) for act in mine] == [("comprehension", 9.5)] * 2


@pytest.mark.parametrize("kind", ["csv", "jsonl", "parquet"])
def test_every_table_is_written_and_none_says_who_or_when(directory, tmp_path, kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    platform = {"PROLIFIC_PID": "5f00ab"}
    take_part(directory, STUDY, ANN, [(0.4, 1, 1)], check=True, answers={"why": "one\rtwo"}, platform=platform)
    take_part(directory, STUDY, CEM, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1)
    (out := tmp_path / "out").mkdir()
    for name in TABLES:
        path, beside = table_of(directory, name).write(out / f"{name}.{kind}", kind)
        for secret in ("5f00ab", "f" * 64, str(int(START))[:6]):
            assert secret.encode() not in path.read_bytes() + beside.read_bytes()
    path, _ = table_of(directory, "participants", platform_ids=True).write(out / f"with.{kind}", kind)
    assert b"5f00ab" in path.read_bytes()
