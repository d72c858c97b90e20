"""``lockprobe report`` of a file of episodes, as it is typed."""

import json
from pathlib import Path

from episode_worlds import made_by_example


def test_it_reports_a_file_and_replaces_no_study(lockprobe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mazes = made_by_example(tmp_path / "mazes.csv")
    status, said, _ = lockprobe("report", mazes, "--json")
    assert (status, json.loads(said)["report"]) == (0, "mazes-report/report.html")
    assert lockprobe("report", mazes, "--first", "8")[1].startswith("Report: mazes-report/report.html\nAnswer: ")
    assert "cannot be combined with a file of episodes" in lockprobe("report", mazes, "--paper")[2]
    assert "none.csv: cannot be read" in lockprobe("report", "none.csv")[2]
    Path("mazes-report/tables/agents,_score.csv").write_text("old")
    assert lockprobe("report", mazes)[0] == 0
    assert not Path("mazes-report/tables/agents,_score.csv").exists()
    Path("report.html").write_text("mine")
    assert "report.html: is not of a report of episodes" in lockprobe("report", mazes, "--out", ".")[2]
    Path("study.json").write_text("{}")
    assert "study.json: is not of a report of episodes" in lockprobe("report", mazes, "--out", ".")[2]
