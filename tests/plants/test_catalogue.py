"""From a plant's spec to the plant."""

import numpy as np
import pytest

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, Missing, UnknownName
from lockprobe.interventions.conditions import read_condition
from lockprobe.plants.catalogue import PLANTS, plant_change, resolve_plant
from lockprobe.plants.symbolic import SymbolicPlant


def test_specs_name_plants_with_options():
    assert isinstance(resolve_plant("symbolic").make(box(), tuple("ABCD"), np.random.default_rng(1)), SymbolicPlant)
    assert [resolve_plant(name).has_camera for name in PLANTS] == [False, True, True, False, False]
    assert [resolve_plant(name).is_attended() for name in PLANTS] == [False, False, False, True, False]
    assert resolve_plant("twin?pose_error=0.004&looks=varied").spec == "twin?pose_error=0.004&looks=varied"


@pytest.mark.parametrize(
    ("spec", "error", "message"),
    [
        ("fast", UnknownName, "no plant is called 'fast' (did you mean 'fast-twin'?)"),
        ("symbolic?tilt=3", BadValue, "plant: got 'symbolic?tilt=3', expected symbolic without options"),
        ("fast-twin?pose_error=1", UnknownName, "no option of fast-twin is called 'pose_error'"),
        ("twin?pose_error=1", BadValue, "pose_error: got 1.0, expected a number from 0 to 0.05"),
        ("twin?tilt=steep", BadValue, "tilt: got 'steep', expected a number"),
        ("twin?looks=odd", BadValue, "looks: got 'odd', expected one of plain, varied"),
        ("fast-twin?width=8", BadValue, "width: got 8, expected a number from 64 to 4096"),
        ("twin?tilt=nan", BadValue, "tilt: got nan, expected a number from 0 to 80"),
    ],
)
def test_a_wrong_spec_is_refused_in_one_line(spec, error, message):
    with pytest.raises(error) as caught:
        resolve_plant(spec)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("name", ["fast-twin", "twin"])
def test_a_plant_is_checked_before_a_study(name, monkeypatch):
    resolve_plant(name).check(box("chain-4"))

    def gone():
        raise Missing("pictures need OpenGL, which does not work here", "install it")

    monkeypatch.setattr("lockprobe_robot.renderer.renderer_name", gone)
    with pytest.raises(Missing, match="^pictures need OpenGL, which does not work here: install it"):
        resolve_plant(name).check(box("chain-4"))


def test_what_the_plant_has_anyway_is_no_change_and_the_rest_is_written_in_one_way():
    change = plant_change("twin?pose_error=0.004", {"pose_error": "0.0040", "looks": "plain", "tilt": "30.0"})
    assert (change.options, change.own) == ({"tilt": "30"}, {"tilt": 20.0})
    assert change.on("twin?pose_error=0.004") == "twin?pose_error=0.004&tilt=30"
    assert plant_change("twin?pose_error=0.004", {"pose_error": "0"}).doses == {"plant.pose_error below 0.004": 0.004}


@pytest.mark.parametrize(
    ("plant", "spec", "error", "message"),
    [
        (
            "twin",
            "plant?pose_eror=1",
            UnknownName,
            "no option of twin is called 'pose_eror' (did you mean 'pose_error'",
        ),
        ("twin", "plant?pose_error=odd", BadValue, "pose_error: got 'odd', expected a number"),
        ("twin", "plant", BadValue, "condition: got 'plant', expected each option of the plant once"),
        ("twin", "plant?tilt=30 + plant?tilt=40", BadValue, "condition: got 'plant?tilt=30 + plant?tilt=40'"),
        (
            "symbolic",
            "plant?pose_error=0.1",
            UnknownName,
            "no option of symbolic is called 'pose_error'; there are: none",
        ),
    ],
)
def test_what_the_plant_has_not_is_refused_in_one_line(plant, spec, error, message):
    with pytest.raises(error) as caught:
        read_condition(spec, plant=plant)
    assert str(caught.value).startswith(message)
