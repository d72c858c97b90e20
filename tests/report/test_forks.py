"""``forks.html`` and the effect by step: numbers of the records, and no such page without forks."""

import json

import pytest
from captions import too_long

from lockprobe.report import write_report
from lockprobe.report.results import results
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.journal import Journal
from lockprobe.studies.runner import run_study
from lockprobe.studies.studyfile import study


@pytest.fixture(scope="module", params=["flips", "why"])
def forked(request, tmp_path_factory):
    """A small study with forks and its report."""
    size = {"trials": 8, "repetitions": 1, "agent": "cognitive:perseverant"}
    planned = study(request.param, **size, **({"p": [0.0, 0.4]} if request.param == "flips" else {}))
    directory = tmp_path_factory.mktemp("forked") / request.param
    key = "flips" if request.param == "flips" else f"why/{planned.agents[0]}/truth"
    trials = run_study(planned, directory)
    chosen = () if request.param == "flips" else (key,)
    wanted = branching(planned, trials, keys=chosen, at=["4", "8"], told=["lie", "retracted"])
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(wanted, journal)
    write_report(directory)
    return request.param, directory, json.loads((directory / "results.json").read_text())


def test_rows_are_effects_of_the_forks_on_record(forked):
    name, _, found = forked
    rows = found["forks"]
    conditions = {"flips": {"truth", "flip?p=0.4"}, "why": {"truth"}}[name]
    assert {row["condition"] for row in rows} == conditions
    assert {row["arm"] for row in rows} == {"lie", "retracted"}
    assert {row["where"] for row in rows} >= {"4", "8"}
    for row in rows:
        assert row["trials"] <= 8
        if row["arm"] == "retracted":  # a policy reads the corrected report alone
            assert row["change"] == 0
    assert any(row["outcome"] == "choice" and row["change"] > 0.3 for row in rows)


def test_the_page_and_the_figure_are_there_and_linked(forked):
    name, directory, found = forked
    page, report = ((directory / one).read_text() for one in ("forks.html", "report.html"))
    assert found["forks_said"][0] in page
    assert 'href="forks.html"' in report
    assert (directory / "figures" / "forks.png").exists()
    assert (directory / "tables" / "forks.csv").exists()
    assert "<script" not in page
    if name == "why":
        why = (directory / "why.html").read_text()
        assert "The effect by step" in why
        assert 'href="forks.html"' in why
    assert results(directory).plain()["forks"] == found["forks"]


def test_forks_are_counted_in_no_number_of_the_study(forked):
    _, directory, found = forked
    assert found["progress"]["finished"] == len((directory / "trials.jsonl").read_text().splitlines())
    assert found["left_out"]["foreign"] == 0


def test_a_study_without_forks_has_no_such_page(tmp_path):
    planned = study("flips", agent="random", p=[0.0], trials=2, repetitions=1)
    run_study(planned, tmp_path)
    write_report(tmp_path)
    assert not (tmp_path / "forks.html").exists()
    assert "forks" not in json.loads((tmp_path / "results.json").read_text())


def test_captions_are_short(forked):
    _, directory, found = forked
    assert too_long((directory / "forks.html").read_text(), found) == []
