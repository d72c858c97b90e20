"""A report that several processes work at is the same, byte by byte; small ones start none."""

import operator
import os

import pytest
from builders import small_study, write_study

from lockprobe.report import sharing, write_report
from lockprobe.report.sharing import shared


def test_jobs_are_shared_and_results_come_in_their_order(tmp_path, monkeypatch):
    monkeypatch.setattr(sharing, "LARGE", 0)
    (tmp_path / "trials.jsonl").write_bytes(b"x")
    with shared(tmp_path, 2) as (each, parts):
        processes = list(each(operator.call, [os.getpid] * 5))
        assert list(each(abs, [-4, 3, -2, 1])) == [4, 3, 2, 1]
    assert parts == 2
    assert [process == os.getpid() for process in processes] == [True, False, True, False, True]


@pytest.mark.parametrize(("size", "processes"), [(10, 4), (sharing.LARGE, 1)])
def test_small_reports_and_single_processes_start_none(tmp_path, size, processes):
    (tmp_path / "trials.jsonl").write_bytes(b"x" * size)
    with shared(tmp_path, processes) as (each, parts):
        assert (each, parts) == (map, 1)


def test_several_processes_change_no_byte(tmp_path, monkeypatch):
    study = small_study(["random", "human-inspired"], (0.0, 0.4), 1, 6)
    one, two = (write_study(tmp_path / name, study) for name in ("one", "two"))
    write_report(one)
    monkeypatch.setattr(sharing, "LARGE", 0)
    write_report(two, processes=2)
    names = ["results.json", "report.html", *(f"figures/{path.name}" for path in (one / "figures").iterdir())]
    assert len(names) > 10
    for name in names:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name
