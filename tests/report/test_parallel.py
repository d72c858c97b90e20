"""A report that several processes work at is the same, byte by byte; small ones start none."""

import gc
import operator
import os
import pickle
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from builders import small_study, write_study

from lockprobe.report import parallel, report_files
from lockprobe.report.opened import open_study
from lockprobe.report.parallel import shared, uncollected
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

LARGE = parallel.LARGE


@pytest.fixture
def large(tmp_path, monkeypatch):
    monkeypatch.setattr(parallel, "LARGE", 0)
    monkeypatch.setattr(parallel, "import_module", len)  # no figure is drawn by these jobs
    monkeypatch.syspath_prepend(Path(__file__).parents[2])  # for another process that is sent work of this module
    (tmp_path / "trials.jsonl").write_bytes(b"x")
    return tmp_path


def until(path):
    """A job that lasts until another has made a file."""

    def waits():
        for _ in range(6000):
            if path.exists():
                return os.getpid()
            time.sleep(0.01)
        return None

    return waits


def killed(parent):
    """A job that kills the process that has taken it, but for the first one, which leaves the other time to take one."""
    if os.getpid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.05)
    return os.getpid()


def test_whoever_is_free_takes_the_next_job_and_what_breaks_or_is_killed_is_raised_or_done_here(large):
    touched, again, breaks = large / "touched", large / "again", partial(int, "x")
    with shared(large, 2) as each:
        first, *others, last = each(operator.call, [until(touched), *[os.getpid] * 5, partial(touched.write_text, "x")])
        assert list(each(abs, [-4, 3, -2, 1])) == [4, 3, 2, 1]
        assert list(each(abs, [])) == []
        for jobs in ([breaks, os.getpid], [until(again), partial(again.write_text, "x"), breaks]):  # here, and there
            with pytest.raises(ValueError, match="invalid literal"):
                each(operator.call, jobs)
        assert each(killed, [os.getpid()] * 6) == [os.getpid()] * 6
    assert (first, last) == (os.getpid(), 1)
    assert len(set(others)) == 1
    assert first not in others


KILLED = """
import os, signal, sys
from operator import call
from pathlib import Path
from lockprobe.report.parallel import shared
if __name__ == "__main__":
    with shared(Path(sys.argv[1]), 2) as each:
        each(call, [lambda: os.kill(os.getpid(), signal.SIGKILL)])
"""


def test_no_process_outlives_one_that_is_killed(large):
    """Whoever reads what it prints sees the end of it only when nobody is left who could print."""
    (large / "trials.jsonl").write_bytes(b"x" * LARGE)
    killed = subprocess.run([sys.executable, "-c", KILLED, str(large)], stdout=subprocess.PIPE, timeout=60, check=False)
    assert killed.returncode == -signal.SIGKILL


@pytest.mark.parametrize(("size", "processes"), [(10, 4), (parallel.LARGE, 1)])
def test_small_reports_and_single_processes_start_none(tmp_path, size, processes):
    (tmp_path / "trials.jsonl").write_bytes(b"x" * size)
    with shared(tmp_path, processes) as each:
        assert each is map


def test_the_collector_is_as_it_was():
    with uncollected():
        assert not gc.isenabled()
        with uncollected():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
    with pytest.raises(ValueError, match="invalid literal"), uncollected():
        int("x")
    assert gc.isenabled()


def test_several_processes_change_no_byte(tmp_path, monkeypatch, drawn):
    planned = small_study(["random", "human-inspired"], (0.0, 0.4), 1, 4)
    one, two = (write_study(tmp_path / name, planned) for name in ("one", "two"))
    monkeypatch.setattr(parallel, "LARGE", 0)
    few = ("fig4", "fig5a", "fig3", "box")  # of each kind of picture one, two of them for slides
    real, all_sections = report_files.figures_of, report_files.all_sections

    def shown(figures):
        return tuple(one for one in figures if one.name in few)

    monkeypatch.setattr(report_files, "figures_of", lambda parts: shown(real(parts)))
    monkeypatch.setattr(
        report_files, "all_sections", lambda: [replace(one, figures=shown(one.figures)) for one in all_sections()]
    )
    with drawn():
        write_report(one, processes=1)
        write_report(two, processes=2)
    names = ["results.json", "report.html", *(f"figures/{path.name}" for path in (one / "figures").iterdir())]
    assert len(names) == 2 + len(few) + 2
    for name in names:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name


class Posted:
    """Other machines: work, jobs and results travel as bytes, and arrive in the order of the jobs."""

    def __init__(self):
        self.jobs = 0

    def map(self, work, jobs):
        for job in jobs:
            self.jobs += 1
            sent, given = pickle.loads(pickle.dumps((work, job)))
            yield pickle.loads(pickle.dumps(sent(given)))


def test_other_machines_do_it_in_the_order_of_the_jobs_and_can_draw_every_figure(large):
    """Functions without a name, such as those that say where a figure applies, cannot be sent there."""
    with shared(large, 2, posted := Posted()) as each:
        assert each(abs, iter([-3, 1, -2])) == [3, 1, 2]
        asked = {"condition": ["nudge", "nudge + flip?p=0.4"], "sweep": "tremble?p=0,0.1,0.2", "p": [0, 0.4]}
        planned = study("flips", agent="cognitive:careful", trials=2, repetitions=1, **asked)
        opened = open_study(write_study(large / "study", planned))
        files = dict(report_files.report_files(opened, tell=lambda said: None, each=each))
    drawn = {name for name, content in files.items() if name.endswith(".svg") and content}
    assert {f"figures/{name}.svg" for name in ("box", "fig4", "fig3")} <= drawn
    assert posted.jobs >= len(drawn)
