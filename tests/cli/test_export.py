"""``lockprobe export``, ``box``, ``replay`` with ``--out``: whole table_files, or none; never in place of a device."""

import json
import os
import stat

import pytest
from builders import small_study, write_study

from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.interfaces.export import table_files

STUDY = small_study(trials=1, repetitions=1)


@pytest.fixture
def played(tmp_path):
    return write_study(tmp_path / "played", STUDY)


WRITERS = [
    ("export", "DIR", "--format", "csv"),
    ("export", "DIR", "--format", "jsonl"),
    ("export", "DIR", "--format", "parquet"),
    ("box", "show"),
    ("replay", "DIR", "flips/random/truth/rep=1/trial=1"),
]
ENDING = {"box": ".svg", "replay": ".gif"}


@pytest.mark.parametrize("arguments", WRITERS, ids=lambda arguments: " ".join(arguments[:4]))
def test_every_command_that_writes_a_file_refuses_a_pipe(lockprobe, tmp_path, played, arguments):
    for package in ("pyarrow", "inspect_ai", "mujoco"):
        pytest.importorskip(package)
    ending = next((ENDING[word] for word in arguments if word in ENDING), ".txt")
    pipe = tmp_path / f"pipe{ending}"
    os.mkfifo(pipe)
    status, _, said = lockprobe(*(played if word == "DIR" else word for word in arguments), "--out", pipe)
    assert (status, said.splitlines()[-1]) == (
        2,
        f"lockprobe: {pipe}: is a pipe, not a regular file: choose another name",
    )
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.parametrize("format_", ["csv", "jsonl", "parquet"])
def test_an_export_that_fails_leaves_the_file_that_was_there(lockprobe, tmp_path, played, monkeypatch, format_):
    pytest.importorskip("pyarrow")
    out = tmp_path / "out" / f"steps.{format_}"
    out.parent.mkdir()
    assert lockprobe("export", played, "--format", format_, "--out", out)[0] == 0
    before, rows = out.read_bytes(), table_files.tidy_rows

    def breaks(trials, *more):
        yield next(rows(trials, *more))
        raise OSError(28, "No space left on device")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    named = out
    if format_ == "parquet":
        named = out.with_name("steps.parquet-metadata.json")  # is forced to the disk first
        monkeypatch.setattr("os.fsync", full)
    else:
        monkeypatch.setattr(table_files, "tidy_rows", breaks)
    status, _, said = lockprobe("export", played, "--format", format_, "--out", out)
    assert (status, said) == (2, f"lockprobe: {named}: cannot be written (No space left on device)\n")
    assert out.read_bytes() == before
    assert not [path for path in out.parent.iterdir() if "draft" in path.name]


def test_a_dash_is_standard_output(lockprobe, tmp_path, played, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert lockprobe("export", played, "--out", "-") == lockprobe("export", played)
    assert "is not text" in lockprobe("export", played, "--format", "parquet", "--out", "-")[2]
    assert not (tmp_path / "-").exists()


@pytest.mark.parametrize("out", ["", ".", ".."])
def test_a_table_without_a_name_is_refused(lockprobe, played, out):
    status, _, said = lockprobe("export", played, "--out", out)
    assert (status, said) == (2, f"lockprobe: {out or '.'}: is a directory, not a regular file: choose another name\n")


@pytest.mark.parametrize("name", ["trials.jsonl", "people/aaaa01.jsonl", "pictures/x.png"])
def test_a_link_to_a_file_of_the_study_is_refused(lockprobe, tmp_path, played, name):
    (tmp_path / "link.csv").symlink_to(played / name)
    status, _, said = lockprobe("export", played, "--out", tmp_path / "link.csv")
    assert (status, said) == (2, f"lockprobe: {tmp_path}/link.csv: belongs to the study; choose another file\n")


def test_a_call_is_a_row_and_a_table_of_people_needs_people(lockprobe, played):
    call = {
        "key": "k",
        "step": 1,
        "turn": 2,
        "request": "r",
        "reply": "{}",
        "usage": {"input_tokens": 5},
        "seconds": 1.5,
    }
    owed = {**call, "reply": None, "error": "owed anew"}
    lines = [with_checksum(json.dumps(one).encode()) + b"\n" for one in (call, owed)]
    (played / "calls.jsonl").write_bytes(b"".join(lines))
    header, row = lockprobe("export", played, "--table", "calls")[1].splitlines()
    assert header == "key,agent,step,call,input_tokens,output_tokens,call_seconds"
    assert row == "k,,1,2,5,0,1.5"
    status, _, said = lockprobe("export", played, "--table", "answers")
    assert (status, said.count("\n")) == (2, 1)
    assert "nobody took part in this study" in said
