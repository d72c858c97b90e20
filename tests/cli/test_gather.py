"""``lockprobe import`` and ``lockprobe export``: out as a log, and back in."""

import json
import sys

import pytest
from builders import small_study, write_study

from lockprobe.cli import main
from lockprobe.studies.journal import load

STUDY = small_study(trials=1, repetitions=1)


@pytest.fixture
def lockprobe(monkeypatch, capsys):
    """Runs a command; gives exit status, output and errors."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["lockprobe", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        return ended.value.code or 0, captured.out, captured.err

    return run


@pytest.fixture
def played(tmp_path):
    return write_study(tmp_path / "played", STUDY)


@pytest.mark.parametrize("out", ["log.eval", "logs"])
def test_out_as_logs_and_in_again(lockprobe, tmp_path, played, out):
    pytest.importorskip("inspect_ai")
    assert lockprobe("export", played, "--format", "eval", "--out", tmp_path / out)[0] == 0
    status, said, _ = lockprobe("import", tmp_path / "new", tmp_path / out)
    assert (status, said.split(".")[0]) == (0, "6 trials taken, 0 were there, 0 were not finished")
    assert {trial.key: trial for trial in load(tmp_path / "new")} == {trial.key: trial for trial in load(played)}
    again = json.loads(lockprobe("import", tmp_path / "new", tmp_path / out, "--json")[1])
    assert (again["taken"], again["there"], again["agents"]) == (0, 6, [])


def test_a_study_may_mix_journals_and_logs(lockprobe, tmp_path, played):
    pytest.importorskip("inspect_ai")
    lockprobe("export", played, "--format", "eval", "--out", tmp_path / "logs")
    log = tmp_path / "logs" / "flips_random.eval"
    other = write_study(tmp_path / "other", small_study(["round-robin"], trials=1, repetitions=1))
    said = json.loads(lockprobe("import", tmp_path / "new", log, other, "--json")[1])
    assert (said["taken"], said["agents"]) == (6, ["random", "round-robin"])


def test_replies_of_trials_that_are_not_finished_are_counted(lockprobe, tmp_path, played):
    lines = (played / "trials.jsonl").read_bytes().splitlines(keepends=True)
    (played / "trials.jsonl").write_bytes(b"".join(lines[1:]))
    call = {"key": json.loads(lines[0])["key"], "step": 1, "turn": 1, "request": "r", "reply": "{}"}
    (played / "calls.jsonl").write_text(json.dumps(call) + "\n")
    said = lockprobe("import", tmp_path / "new", played)[1]
    assert "5 trials taken, 0 were there, 1 were not finished. They go on from 1 replies" in said


def test_parquet_without_its_package_is_one_line(lockprobe, tmp_path, played, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    status, _, said = lockprobe("export", played, "--format", "parquet", "--out", tmp_path / "x.parquet")
    assert (status, said) == (2, "lockprobe: Parquet needs the package pyarrow: pip install 'lockprobe[parquet]'\n")


@pytest.mark.parametrize("format_", ["parquet", "eval"])
def test_what_is_no_text_needs_a_file(lockprobe, played, format_):
    status, _, said = lockprobe("export", played, "--format", format_)
    assert status == 2
    assert f"since {format_} is no text" in said


@pytest.mark.parametrize("name", ["study.json", "trials.jsonl", "calls.jsonl"])
def test_no_file_of_the_study_is_written_over(lockprobe, played, name):
    before = (played / "trials.jsonl").read_bytes()
    assert lockprobe("export", played, "--out", played / name)[0] == 2
    assert (played / "trials.jsonl").read_bytes() == before


def test_mistakes_are_one_line(lockprobe, tmp_path, played):
    (tmp_path / "empty").mkdir()
    for source, said in (
        (tmp_path / "nowhere", "no such file"),
        (played, "another directory"),
        (tmp_path / "empty", "neither"),
    ):
        status, _, error = lockprobe("import", played, source)
        assert (status, error.count("\n")) == (2, 1)
        assert said in error
