"""A report is made without the collector of garbage; a cluster can draw it, and small ones are made here."""

import gc
import pickle

import pytest
from builders import write_study

from lockprobe.report import processor, report_files
from lockprobe.report.opened import open_study
from lockprobe.report.processor import each_on, uncollected
from lockprobe.studies.options.studyfile import study


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


class Posted:
    """Other machines: work, jobs and results travel as bytes, and arrive in the order of the jobs."""

    def __init__(self):
        self.jobs = 0

    def map(self, work, jobs):
        for job in jobs:
            self.jobs += 1
            sent, given = pickle.loads(pickle.dumps((work, job)))
            yield pickle.loads(pickle.dumps(sent(given)))


def test_other_machines_do_large_ones_in_the_order_of_the_jobs_and_can_draw_every_figure(tmp_path):
    """Functions without a name, such as those that say where a figure applies, cannot be sent there."""
    asked = {"condition": ["nudge", "nudge + flip?p=0.4"], "sweep": "tremble?p=0,0.1,0.2", "p": [0, 0.4]}
    planned = study("flips", agent="cognitive:careful", trials=2, repetitions=1, **asked)
    opened = open_study(write_study(tmp_path, planned))
    posted = Posted()
    assert each_on(posted, tmp_path) is map
    with (tmp_path / "trials.jsonl").open("ab") as records:
        records.write(b" " * processor.LARGE)
    assert each_on(None, tmp_path) is map
    each = each_on(posted, tmp_path)
    assert each(abs, iter([-3, 1, -2])) == [3, 1, 2]
    files = dict(report_files.report_files(opened, tell=lambda said: None, each=each))
    drawn = {name for name, content in files.items() if name.endswith(".svg") and content}
    assert {f"figures/{name}.svg" for name in ("box", "fig4", "fig3")} <= drawn
    assert posted.jobs >= len(drawn)
    assert files == dict(report_files.report_files(opened, tell=lambda said: None))
