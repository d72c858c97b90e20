"""A person moves the joints: what they type is the truth."""

import io
from dataclasses import replace

import pytest
from builders import small_study
from plants.person import Person

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import UserMistake
from lockprobe.plants.manual import Manual
from lockprobe.plants.operator import OperatorStopped
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.testing import check_plant

FIVE = box("random-5-3")
LABELS = ("C", "A", "E", "D", "B")


def plant_with(person, **parts):
    return Manual(person.box, labels=LABELS[: len(person.box.joints)], operator=person, **parts)


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


def test_at_the_terminal_q_owes_the_trial_again_and_the_end_of_input_ends_the_run(tmp_path, monkeypatch, capsys):
    """Also where workers are asked for: the trials are played in the process that has the terminal."""
    monkeypatch.setattr("sys.stdin", io.StringIO("\nn\nn\nq\n"))
    study = replace(small_study(["random"], p=[0.0], repetitions=1, trials=2), plant="manual")
    with pytest.raises(UserMistake) as ended:
        run_study(study, tmp_path, limits=Limits(workers=4))
    assert str(ended.value) == (
        "the input ended before the operator answered; no trial had begun, so nothing is lost: the same command goes on"
    )
    (trial,) = load(tmp_path)
    assert (trial.error.boundary, trial.error.message, trial.owed_again) == ("plant", "the operator stopped", True)
    assert capsys.readouterr().out == ""
