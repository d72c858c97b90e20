"""Measures of installed packages: in results.json, in a table and on the page."""

import strangers
from builders import play_study, small_study, write_study
from reported import tables_of

from lockprobe.foundation.formatting import NONE
from lockprobe.report.format import entry_text
from lockprobe.report.page import write_report
from lockprobe.report.results import results
from lockprobe.statistics.measures import find_measure, measured

STUDY = small_study(["random"], p=[0.0, 0.6], repetitions=1)
POINTS = {"measures": {"untold": "untold", "hasty": "hasty", "breaks": "breaks"}}
SAID = "Whether it was solved in five steps"


def test_every_condition_has_the_mean_of_each_and_of_one_that_breaks_the_reason(tmp_path, monkeypatch):
    trials = play_study(STUDY)
    path = write_study(tmp_path / "study", STUDY, trials)
    assert SAID not in write_report(path).read_text("utf-8")
    assert results(path).measures == []
    assert not (path / "tables" / "measures.csv").exists()
    strangers.install(tmp_path, monkeypatch, points=POINTS)
    assert SAID in write_report(path).read_text("utf-8")
    found = results(path)
    names = ("measures.breaks", "measures.hasty", "measures.untold")
    asked = [("random", condition, name) for condition in ("truth", "flip?p=0.6") for name in names]
    assert [(row.agent, row.condition, row.quantity) for row in found.measures] == asked
    assert {row.source for row in found.measures} == {"strange-things 0.3"}
    for row in found.measures:
        own = [trial for trial in trials if trial.condition == row.condition]
        if row.quantity == "measures.breaks":
            assert (row.unit, row.n, row.value, row.low, row.high) == ("", 0, None, None, None)
            assert "does not work (ZeroDivisionError: by nothing)" in row.note
        else:
            one = measured(own, find_measure(row.quantity.removeprefix("measures.")))
            assert (row.value, row.low, row.high, row.n) == (one.value, one.low, one.high, 4)
    head, *lines = tables_of(found)["measures"]
    assert head[-1] == "mean [95 % interval]"
    said = {(line[1], line[2]): line[-1] for line in lines}
    hasty = found.one("measures.hasty", condition="truth")
    assert said["truth", "hasty"] == entry_text(hasty)
    assert said["truth", "breaks"] == NONE
    assert said["truth", "untold"] == "0"  # the same in every trial: no interval
