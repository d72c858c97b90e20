"""results.json has a published schema, and a report of every kind keeps to it."""

import json
import math
from pathlib import Path

import pytest
from builders import small_study, write_study
from pydantic import ValidationError

import lockprobe
from lockprobe.analysis.clustered import ClusteredProportion
from lockprobe.report import write_report
from lockprobe.report.schema import Results
from lockprobe.studies.studyfile import study

PUBLISHED = Path(__file__).parents[2] / "docs" / "results.schema.json"


def test_the_published_schema_is_that_of_the_types():
    assert json.loads(PUBLISHED.read_text()) == Results.model_json_schema()


def test_every_field_is_described():
    found = Results.model_json_schema()
    for kind in found["$defs"].values():
        assert kind["description"]
        assert all("description" in about for about in kind["properties"].values())


@pytest.mark.parametrize("of_flips", [True, False])
def test_a_report_keeps_to_it(tmp_path, of_flips):
    planned = small_study(trials=3) if of_flips else study("flips", agent="random", condition="nudge", trials=2)
    directory = write_study(tmp_path / "study", planned)
    write_report(directory)
    written = Results.model_validate_json((directory / "results.json").read_text())
    found = lockprobe.results(directory)
    assert written == found
    assert type(written.conditions[0].misread) is type(found.conditions[0].misread) is ClusteredProportion
    assert {row.agent for row in found.conditions} == set(planned.agents)
    assert len(found.conditions) == sum(len(planned.conditions_of(agent)) for agent in planned.agents)
    assert bool(found.effects) != of_flips


def test_a_null_is_read_as_no_number_where_a_share_is_of_nothing(tmp_path):
    directory = write_study(tmp_path / "study", small_study(["random"], (0.0,), 1, 2))
    content = lockprobe.results(directory).plain()
    assert content["conditions"][0]["misread"]["value"] is None
    read = Results.model_validate_json(json.dumps(content))
    assert math.isnan(read.conditions[0].misread.value)
    assert read.plain() == content


def test_what_is_no_result_is_refused():
    with pytest.raises(ValidationError):
        Results.model_validate({"schema_version": 3})
