"""From a plant's spec to the plant, and a person as one, whose answers at the terminal are the truth."""

import io
from dataclasses import replace

import numpy as np
import pytest
from builders import small_study
from plants.person import Person

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, Missing, UnknownName, UserMistake
from lockprobe.interventions.conditions import read_condition
from lockprobe.plants.catalogue import PLANTS, plant_change, resolve_plant
from lockprobe.plants.manual import ENTER, Manual, OperatorStopped, TerminalOperator
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.testing import check_plant


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
    ((part, doses),) = plant_change("twin?pose_error=0.004", {"pose_error": "0"}).parts
    assert (dict(part.options), doses) == ({"pose_error below 0.004": "0.004"}, ("pose_error below 0.004",))


@pytest.mark.parametrize(
    ("plant", "spec", "error", "message"),
    [
        ("twin", "plant?pose_eror=1", UnknownName, "no option of twin is called 'pose_eror' (did you mean 'pose_error'"),
        ("twin", "plant?pose_error=odd", BadValue, "pose_error: got 'odd', expected a number"),
        ("twin", "plant", BadValue, "condition: got 'plant', expected each option of the plant once"),
        ("twin", "plant?tilt=30 + plant?tilt=40", BadValue, "condition: got 'plant?tilt=30 + plant?tilt=40'"),
        ("symbolic", "plant?pose_error=0.1", UnknownName, "no option of symbolic is called 'pose_error'; there are: none"),
    ],
)  # fmt: skip
def test_what_the_plant_has_not_is_refused_in_one_line(plant, spec, error, message):
    with pytest.raises(error) as caught:
        read_condition(spec, plant=plant)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("typed", "answers", "answer"),
    [
        ("y\n", "yn", "y"),
        ("  NO \n", "yn", "n"),
        ("yes", "yn", "y"),
        ("\n", (ENTER,), ENTER),
        ("x\n\ny\n", "yn", "y"),
        ("q\n", "yn", "the operator stopped"),
        ("Quit\n", "yn", "the operator stopped"),
        ("", "yn", "the input ended before the operator answered"),
    ],
)
def test_an_answer_is_typed_and_what_is_none_is_asked_again(typed, answers, answer, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO(typed))
    try:
        found = TerminalOperator().ask("Did it move?", [*answers])
    except OperatorStopped as stopped:
        found = str(stopped)
    assert found == answer
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("Did it move? ") == 1 + printed.err.count("Not an answer here: type y, n, or q to stop.")


LABELS = ("C", "A", "E", "D", "B")


def plant_with(person):
    return Manual(person.box, labels=LABELS[: len(person.box.joints)], operator=person)


def test_a_person_who_obeys_the_rules_is_a_plant():
    check_plant(lambda box, labels, rng: Manual(box, labels=labels, operator=Person(box)), attempts=15)


@pytest.mark.parametrize(("slips", "as_rules"), [(["y"], True), (["y", "y"], False)])
def test_an_answer_against_the_rules_is_asked_again_and_then_believed(slips, as_rules):
    """The target of chain-4 is locked at the start."""
    plant = plant_with(Person(box("chain-4"), slips=slips))
    plant.observe()
    seen = plant.attempt(0)
    assert seen.sensed == {"truth": "person", "as_rules": as_rules}
    assert (seen.outcome == "moved", seen.configuration[0]) == (not as_rules, not as_rules)


def test_who_stops_breaks_the_trial_and_who_stops_before_it_ends_the_run():
    plant = plant_with(Person(box("chain-4"), patience=1))
    plant.observe()
    with pytest.raises(OperatorStopped) as stopped:
        plant.attempt(1)
    assert stopped.value.boundary == "plant"
    with pytest.raises(UserMistake, match="no trial had begun, so nothing is lost: the same command goes on"):
        plant_with(Person(box("chain-4"), patience=0)).observe()


def test_at_the_terminal_q_owes_the_trial_again_and_the_end_of_input_ends_the_run(tmp_path, monkeypatch):
    """Also where workers are asked for: the trials are played in the process that has the terminal."""
    monkeypatch.setattr("sys.stdin", io.StringIO("\nn\nn\nq\n"))
    study = replace(small_study(["random"], p=[0.0], repetitions=1, trials=2), plant="manual")
    with pytest.raises(UserMistake, match="^the input ended before the operator answered; no trial had begun"):
        run_study(study, tmp_path, limits=Limits(workers=4))
    (trial,) = load(tmp_path)
    assert (trial.error.boundary, trial.error.message, trial.owed_again) == ("plant", "the operator stopped", True)
