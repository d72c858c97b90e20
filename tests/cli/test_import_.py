"""``lockprobe import``, and ``lockprobe export`` of what was imported."""

import json
import sys
from dataclasses import replace

import pytest
from builders import small_study, write_study
from taking_part import take_part

from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.studies.records.read_records import load

STUDY = small_study(trials=1, repetitions=1)


@pytest.fixture
def played(tmp_path):
    return write_study(tmp_path / "played", STUDY)


def test_replies_of_trials_that_are_not_finished_are_counted(lockprobe, tmp_path, played):
    lines = (played / "trials.jsonl").read_bytes().splitlines(keepends=True)
    (played / "trials.jsonl").write_bytes(b"".join(lines[1:]))
    call = {"key": json.loads(lines[0])["key"], "step": 1, "turn": 1, "request": "r", "reply": "{}"}
    (played / "calls.jsonl").write_bytes(with_checksum(json.dumps(call).encode()) + b"\n")
    said = lockprobe("import", tmp_path / "new", played)[1]
    assert "5 trials imported, 0 already there, 1 unfinished. 1 replies of unfinished trials were imported" in said


def test_parquet_without_its_package_is_one_line(lockprobe, tmp_path, played, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    status, _, said = lockprobe("export", played, "--format", "parquet", "--out", tmp_path / "x.parquet")
    assert (status, said) == (2, "lockprobe: Parquet needs the package pyarrow: pip install 'lockprobe[parquet]'\n")


@pytest.fixture
def people(tmp_path):
    study = small_study(["participant"], trials=1, repetitions=1)
    take_part(tmp_path / "people", study, "aaaa01", [(0.0, 1, 1)], platform={"PROLIFIC_PID": "5f00ab"})
    take_part(tmp_path / "people", study, "bbbb02", [(0.3, 1, 1), (0.6, 1, 1)], left_after=1)
    return tmp_path / "people"


def test_people_are_taken_in_beside_strategies_with_their_times(lockprobe, played, people):
    status, said, _ = lockprobe("import", played, people)
    assert status == 0
    assert "2 trials imported, 0 already there, 0 unfinished. New agents: participant. 2 participants." in said
    again = json.loads(lockprobe("import", played, people, "--json")[1])
    assert (again["taken"], again["there"], again["participants"]) == (0, 2, 0)
    rows = [json.loads(line) for line in lockprobe("export", played, "--format", "jsonl")[1].splitlines()]
    times = {(row["agent"], row["step"]): row["rt_ms"] for row in rows}
    assert (times["participant:aaaa01", 1], times["random", 1]) == (1001.5, "")


def test_it_is_said_how_many_boxes_of_people_here_are_gone(lockprobe, tmp_path, people):
    study = small_study(["participant"], trials=1, repetitions=1)
    take_part(tmp_path / "here", study, "cccc03", [(0.6, 1, 1), (0.0, 1, 1)], left_after=2)
    said = lockprobe("import", tmp_path / "here", people)[1]
    assert "1 boxes assigned to participants here" in said
    assert json.loads(lockprobe("import", tmp_path / "here", people, "--json")[1])["places_lost"] == 1


def test_parquet_has_times_as_numbers(lockprobe, tmp_path, people):
    parquet = pytest.importorskip("pyarrow.parquet")
    assert lockprobe("export", people, "--format", "parquet", "--out", tmp_path / "x.parquet")[0] == 0
    table = parquet.read_table(tmp_path / "x.parquet")
    assert str(table.schema.field("rt_ms").type) == "double"
    assert table.column("rt_ms").to_pylist()[0] == 1001.5


def test_another_prompt_under_the_same_name_is_refused_aloud_and_leaves_nothing(lockprobe, tmp_path, played):
    other = write_study(tmp_path / "other", STUDY, [replace(t, facts={"prompt": "chat b"}) for t in load(played)])
    first = write_study(tmp_path / "first", STUDY, [replace(t, facts={"prompt": "chat a"}) for t in load(played)])
    before = (first / "trials.jsonl").read_bytes()
    status, said, error = lockprobe("import", first, other)
    assert (status, said, error.count("\n")) == (2, "", 1)
    assert "other: 0 trials taken: " in error
    assert "is not the same there (prompt is 'chat b', 'chat a' in" in error
    assert (first / "trials.jsonl").read_bytes() == before
    assert lockprobe("import", tmp_path / "new", first, other)[0] == 2
    assert not (tmp_path / "new").exists()


def test_mistakes_are_one_line(lockprobe, tmp_path, played):
    (tmp_path / "empty").mkdir()
    for source, said in (
        (tmp_path / "nowhere", "no such file"),
        (played, "a directory other than DIR"),
        (tmp_path / "empty", "not a study directory"),
    ):
        status, _, error = lockprobe("import", played, source)
        assert (status, error.count("\n")) == (2, 1)
        assert said in error
