"""Crossed doses on the page: a cell for each combination, and the interaction in numbers and in a sentence."""

import json

import pytest
from builders import write_study
from captions import too_long

from lockprobe.report import write_report
from lockprobe.report.schema import Results
from lockprobe.studies.journal import load
from lockprobe.studies.studyfile import study

ASKED = {
    "agent": ["human-inspired", "random"], "sweep": "flip?p=0,0.2,0.4 + tremble?p=0,0.1,0.4", "trials": 10,
    "repetitions": 2,
}  # fmt: skip


@pytest.fixture(scope="module")
def reported(tmp_path_factory, drawn):
    directory = write_study(tmp_path_factory.mktemp("grid") / "study", study("flips", **ASKED))
    with drawn("grid-1"):
        page = write_report(directory).read_text()
    return directory, page, json.loads((directory / "results.json").read_text())


def test_cells_are_the_counts_of_the_records(reported):
    directory, _, content = reported
    played = load(directory)
    assert [row["agent"] for row in content["grids"]] == ASKED["agent"]
    for row in content["grids"]:
        assert (row["rows"]["values"], row["columns"]["values"]) == ([0, 0.2, 0.4], [0, 0.1, 0.4])
        assert len(row["cells"]) == 9
        for cell in row["cells"]:
            own = [one for one in played if (one.agent, one.condition) == (row["agent"], cell["condition"])]
            assert (cell["trials"], cell["solved"]) == (len(own), sum(one.solved for one in own))


def test_the_interaction_is_told_once_and_not_pair_by_pair(reported):
    _, page, content = reported
    assert content["crossings"] == []  # each interaction is tested once, in its grid
    said = [one for one in content["condition_findings"] if "linear trends" in one]
    assert len(said) == len(content["subjects"])
    assert all("linear trends over 9 conditions" in one for one in said)
    assert not any("where" in one for one in content["condition_findings"])
    assert "Interactions of doses" in page


def test_an_agent_that_is_never_told_has_no_interaction(reported):
    _, _, content = reported
    random = content["grids"][1]
    assert (random["difference"], random["detectable"], random["corrected_for"]) == (0, False, 2)


def test_there_is_a_picture_and_both_tables(reported):
    directory, page, _ = reported
    assert (directory / "figures" / "grid-1.svg").read_bytes().startswith(b"<?xml")
    rows = (directory / "tables" / "grids.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * 9
    assert "interaction, points" in (directory / "tables" / "trends.csv").read_text().splitlines()[0]
    assert 'alt="Success under every combination of two doses' in page


def test_results_have_grids_as_types(reported):
    _, _, content = reported
    found = Results.model_validate(content).grids
    assert [row.cells[0].success for row in found] == [row["cells"][0]["success"] for row in content["grids"]]


def test_captions_are_short(reported):
    _, page, content = reported
    assert too_long(page, content) == []
