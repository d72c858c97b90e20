"""``lockprobe run --shard`` as it is typed, and ``lockprobe import`` after it."""

from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load


def test_joined_they_are_the_study_byte_for_byte(lockprobe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    agents = ("--agent", "human-inspired", "--agent", "random")
    asked = ("run", "flips", *agents, "--p", "0,0.4", "--trials", "3", "--no-report")
    for number in (1, 2, 3):
        status, _, _ = lockprobe(*asked, "--shard", f"{number}/3", "--out", f"part-{number}")
        assert status == 0
        played = len(load(tmp_path / f"part-{number}"))
        assert read_study(tmp_path / f"part-{number}").size == played < 36
        assert lockprobe(*asked, "--shard", f"{number}/3", "--out", f"part-{number}")[0] == 0
        assert len(load(tmp_path / f"part-{number}")) == played
    lockprobe("import", "joined", "part-1", "part-2", "part-3")
    lockprobe(*asked, "--out", "whole")
    of = ("--table", "records", "--format", "jsonl")
    joined, whole = (lockprobe("export", name, *of)[1] for name in ("joined", "whole"))
    assert joined == whole
    assert whole.count("\n") == 36
