"""A condition on disk is that condition again; what is not true of its plant is refused."""

import json

import pytest
from builders import write_study

from lockprobe.foundation.errors import BadFile
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study


def test_a_change_of_the_plant_is_read_back_and_a_false_one_is_refused(tmp_path):
    planned = study("flips", agent="random", plant="twin", condition="flip?p=0.4 + plant?friction=0.3&looks=varied")
    path = write_study(tmp_path / "study", planned, []) / "study.json"
    found = read_study(path.parent)
    assert (found, found.conditions[-1].plant) == (planned, planned.conditions[-1].plant)
    assert found.conditions[-1].doses == {"flip.p": 0.4, "plant.friction below 1": 0.7}
    settings = json.loads(path.read_text("utf-8"))
    change = settings["conditions"][-1]["plant"]
    for false in (
        {"own": {"friction": 0.5}},
        {"options": {"looks": "plain"}, "own": {}},
        {"own": {"looks": 1.0}},
    ):
        settings["conditions"][-1]["plant"] = change | false
        path.write_text(json.dumps(settings), "utf-8")
        with pytest.raises(BadFile, match="plant"):
            read_study(path.parent)
