"""What a condition changes of a plant: only what differs, written in one way."""

import pytest

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.conditions import read_condition
from lockprobe.plants.changed_options import plant_change
from lockprobe.studies.options.studyfile import study


def test_what_the_plant_has_anyway_is_no_change_and_the_rest_is_written_in_one_way():
    change = plant_change("twin?pose_error=0.004", {"pose_error": "0.0040", "looks": "plain", "tilt": "30.0"})
    assert (change.options, change.own) == ({"tilt": "30"}, {"tilt": 20.0})
    assert change.on("twin?pose_error=0.004") == "twin?pose_error=0.004&tilt=30"
    assert plant_change("twin?pose_error=0.004", {"pose_error": "0"}).doses == {"plant.pose_error below 0.004": 0.004}


def test_a_plant_of_another_package_that_says_nothing_takes_any_option_and_has_no_dose():
    change = plant_change("python:mine:Hand?grip=3", {"grip": "3", "slip": "0.1"})
    assert (change.options, change.doses) == ({"slip": "0.1"}, {})


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


def test_conditions_of_equal_plants_are_one_condition():
    with pytest.raises(BadValue, match="another condition than one, which is the same"):
        study("flips", plant="twin", condition=["one=plant?pose_error=0.01", "two=plant?pose_error=0.010"])
