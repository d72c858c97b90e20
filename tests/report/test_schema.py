"""results.json has a published schema, and a report of every kind keeps to it."""

import json
from pathlib import Path

import pytest
from builders import small_study, write_study
from pydantic import ValidationError

import lockprobe
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

PUBLISHED = Path(__file__).parents[2] / "docs" / "results.schema.json"


def test_the_published_schema_is_that_of_the_types():
    assert json.loads(PUBLISHED.read_text("utf-8")) == Results.model_json_schema()


def test_every_field_is_described():
    found = Results.model_json_schema()
    for kind in (found, *found["$defs"].values()):
        assert kind["description"]
        assert all("description" in about for about in kind["properties"].values())


@pytest.mark.parametrize("of_flips", [True, False])
def test_a_report_keeps_to_it(tmp_path, of_flips):
    planned = small_study(trials=3) if of_flips else study("flips", agent="random", condition="nudge", trials=2)
    directory = write_study(tmp_path / "study", planned)
    write_report(directory)
    text = (directory / "results.json").read_bytes()
    written, found = Results.model_validate_json(text), lockprobe.results(directory)
    assert written == found
    assert written.plain() == json.loads(text)
    cells = {(cell.agent, cell.condition) for cell in found.cells}
    assert cells == {(agent, one.label) for agent in planned.agents for one in planned.conditions_of(agent)}
    assert bool(found.where("success_difference", family="conditions against the control")) != of_flips


def test_a_share_of_nothing_has_no_row(tmp_path):
    """Agents that say nothing of what happened can misread nothing."""
    directory = write_study(tmp_path / "study", small_study(["random"], (0.0,), 1, 2))
    found = lockprobe.results(directory)
    assert found.where("success")
    assert not found.where("misread")


def test_what_is_no_result_is_refused():
    with pytest.raises(ValidationError):
        Results.model_validate({"schema_version": 4})
