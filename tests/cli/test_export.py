"""``lockprobe export``, ``box``, ``replay`` with ``--out``: whole files, or none; never in place of a device."""

import hashlib
import json
import os
import stat

import pytest
from builders import make_trial, small_study, write_study
from stored import sql

from lockprobe.cli.export import refuse_study_file
from lockprobe.foundation.errors import BadFile
from lockprobe.interfaces.export import Table
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load, results_hash

STUDY = small_study(trials=1, repetitions=1)


@pytest.fixture
def played(tmp_path):
    return write_study(tmp_path / "played", STUDY)


WRITERS = [
    ("export", "DIR", "--format", "csv"),
    ("export", "DIR", "--format", "parquet"),
    ("export", "DIR", "--format", "jsonl", "--table", "records"),
    ("box", "show"),
    ("replay", "DIR", "flips/random/truth/rep=1/trial=1"),
]
ENDING = {"box": ".svg", "replay": ".gif"}


@pytest.mark.parametrize("arguments", WRITERS, ids=lambda arguments: " ".join(arguments[:4]))
def test_every_command_that_writes_a_file_refuses_a_pipe(lockprobe, tmp_path, played, arguments):
    for package in ("pyarrow", "mujoco"):
        pytest.importorskip(package)
    ending = next((ENDING[word] for word in arguments if word in ENDING), ".txt")
    pipe = tmp_path / f"pipe{ending}"
    os.mkfifo(pipe)
    status, _, said = lockprobe(*(played if word == "DIR" else word for word in arguments), "--out", pipe)
    assert status == 2
    assert said.splitlines()[-1] == f"lockprobe: {pipe}: not a regular file"
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_an_export_that_fails_leaves_the_file_that_was_there(lockprobe, tmp_path, played, monkeypatch):
    out = tmp_path / "out" / "steps.csv"
    out.parent.mkdir()
    assert lockprobe("export", played, "--out", out)[0] == 0
    before, rows = out.read_bytes(), Table.rows

    def breaks(table):
        yield next(rows(table))
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Table, "rows", breaks)
    status, _, said = lockprobe("export", played, "--out", out)
    assert (status, said) == (2, f"lockprobe: {out}: cannot be written (No space left on device)\n")
    assert out.read_bytes() == before
    assert not [path for path in out.parent.iterdir() if "draft" in path.name]


def test_a_dash_is_standard_output(lockprobe, tmp_path, played, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert lockprobe("export", played, "--out", "-") == lockprobe("export", played)
    assert not (tmp_path / "-").exists()


def test_a_call_is_a_row_and_a_table_of_people_needs_people(lockprobe, played):
    call = {"key": "k", "step": 1, "turn": 2, "request": "r", "reply": "{}", "seconds": 1.5}
    call |= {"usage": {"input_tokens": 5}}
    sql(played, "insert into call values (null, 'k', ?1, checksum('k', ?1))", json.dumps(call))
    header, row = lockprobe("export", played, "--table", "calls")[1].splitlines()
    assert header == "key,agent,step,call,input_tokens,output_tokens,call_seconds"
    assert row == "k,,1,2,5,0,1.5"
    status, _, said = lockprobe("export", played, "--table", "answers")
    assert (status, said.count("\n")) == (2, 1)
    assert "nobody took part in this study" in said


def test_records_are_a_line_per_trial_by_key_and_exactly_what_the_hash_of_the_results_covers(
    lockprobe, tmp_path, played
):
    """As any other program reads them. Records that were replaced are left out."""
    trials = load(played)
    again = make_trial([0], agent="random", p=0.3, broken="plant", study="flips")
    kept = [trial for trial in trials[1:] if trial.key != again.key]
    finished = next(trial for trial in trials if trial.key == again.key)
    directory = write_study(tmp_path / "other", STUDY, [*reversed(kept), again, trials[0], finished])
    export = ("export", directory, "--table", "records", "--format", "jsonl")
    status, printed, said = lockprobe(*export)
    assert (status, said) == (0, "")
    out = tmp_path / "records.jsonl"
    assert lockprobe(*export, "--out", out)[1] == f"{out}\n"
    assert out.read_bytes() == printed.encode()
    read = [json.loads(line) for line in out.read_text("utf-8").splitlines()]
    assert [one["key"] for one in read] == sorted(trial.key for trial in trials)
    for one, trial in zip(read, sorted(trials, key=lambda trial: trial.key), strict=True):
        steps = [(step["joint"], step["moved"], step["told_moved"]) for step in one["steps"]]
        assert steps == [(step.joint, step.moved, step.told_moved) for step in trial.steps]
        assert (one["agent"], one["ending"], one["condition"]) == (trial.agent, trial.ending, trial.condition)
    digest = hashlib.sha256(out.read_bytes()).hexdigest()
    whole = hashlib.sha256(f"{read_study(directory).settings_hash} {digest}".encode()).hexdigest()
    assert results_hash(read_study(directory), (line.encode() for line in printed.splitlines())) == whole[:32]


STORES = ("study.db", "study.db-wal", "study.db-shm", "study.db-journal", "study.db.rescued", "study.db.rescued-2")
KEPT = (*STORES, "results.json", "people/experiment.json", "pictures/new.png")


def test_what_a_study_keeps_is_refused_and_other_files_beside_it_are_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link.csv").symlink_to(tmp_path / "study.db")
    kept = ("study.json", *KEPT, "report.html", "link.csv")
    for name in kept:
        refuse_study_file(tmp_path / "elsewhere" / name)  # there is no study
        refuse_study_file(tmp_path / name)
    (tmp_path / "study.json").write_text("{}")
    for name in kept:
        for path in (tmp_path / name, tmp_path / "no" / ".." / name, tmp_path.relative_to(tmp_path) / name):
            with pytest.raises(BadFile, match="belongs to the study; choose another file"):
                refuse_study_file(path)
    for name in ("steps.csv", "compare.html", "tables/steps.csv", "inner/study.db"):
        refuse_study_file(tmp_path / name)
