"""The practice box and the example box are no boxes of the study, and report truly."""

import asyncio

import pytest
from seated import people_study, short, under
from seen import PhotographedPlant

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import PlantFault
from lockprobe.people.experiment import Experiment
from lockprobe.people.practice import example_box, examples_of, practice_plan
from lockprobe.people.texts import read_words
from lockprobe.plants import catalogue
from lockprobe.trial.record import STATES


def test_the_practice_is_another_box_with_true_reports_for_everybody_the_same():
    study = people_study(p=(0.4,), layout="shuffled", max_steps=9)
    plan = practice_plan(study, Experiment(practice="chain-2"))
    assert (plan.p, plan.box.name, plan.budget, plan.modality) == (0.0, "chain-2", 9, study.modalities[0])
    assert plan == practice_plan(study, Experiment(practice="chain-2"))
    assert plan.seed != study.seed
    assert practice_plan(study, short()) is None
    pictured = people_study(p=(0.0,), plant="fast-twin", modalities=("rgb",))
    assert practice_plan(pictured, Experiment()).modality == "rgb"


def shown(study):
    return asyncio.run(examples_of(study, read_words("en").page))


@pytest.mark.parametrize("name", ["chain-2", "chain-3", "chain-4", "chain-5", "gray-code"])
def test_it_is_none_of_the_boxes_of_the_study(name):
    study = people_study(box=box(name))
    example = example_box(study)
    assert len(example.joints) != len(study.box.joints)
    target, theirs = example.joints[example.target_index], study.box.joints[study.box.target_index]
    assert (target.kind, example.target_index == 0) != (theirs.kind, study.box.target_index == 0)
    assert not any(example.interlock.values())


def test_it_tells_truly_what_a_step_did():
    found = shown(people_study(p=(0.4, 1.0), modalities=(STATES, "symbolic")))
    assert list(found) == [STATES, "symbolic"]
    assert found[STATES][1].outcome is None
    before, after = found["symbolic"]
    assert (before.view, before.last, before.outcome) == ("panel", None, None)
    assert (after.view, after.outcome) == ("panel", "moved")
    assert [joint.position for joint in after.joints] == [joint.position for joint in found[STATES][1].joints]
    assert [joint.label for joint in after.joints if joint.position] == [after.last]
    assert all(joint.kind is not None for joint in after.joints)


def test_where_no_positions_are_told_it_shows_none():
    before, after = shown(people_study(flip="outcome-only"))["symbolic?tell=outcome"]
    assert {joint.position for panel in (before, after) for joint in panel.joints} == {None}
    assert after.outcome == "moved"


def camera(monkeypatch, plant):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: plant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)


def test_each_modality_has_its_own(monkeypatch):
    camera(monkeypatch, PhotographedPlant)
    study = people_study(p=(0.0,), modalities=("symbolic", "rgb", "rgbd"), plant="fast-twin")
    found = shown(study)
    assert [(name, after.view, len(after.pictures)) for name, (_, after) in found.items()] == [
        ("symbolic", "panel", 0), ("rgb", "pictures", 1), ("rgbd", "pictures", 2)
    ]  # fmt: skip
    for before, after in found.values():
        assert before.last is None
        assert after.last in {joint.label for joint in after.joints}
        assert (before.pictures != after.pictures) is (after.view == "pictures")


def test_where_the_plant_breaks_there_is_none(monkeypatch):
    def broken(box):
        raise PlantFault("no light")

    camera(monkeypatch, broken)
    assert shown(people_study(p=(0.0,), modalities=("rgb",), plant="fast-twin")) == {}


CONDITIONS = ("flip?p=1", "nudge + tremble?p=1", "warn", "delay?lag=2", "drop?p=1")


def test_nothing_of_a_study_s_conditions_acts_in_practice_and_example():
    study = under(*CONDITIONS)
    plan = practice_plan(study, Experiment())
    assert (plan.condition.specs, plan.modality) == ((), STATES)
    assert shown(study) == shown(under("truth"))


def test_no_picture_of_practice_and_example_is_false_or_degraded(monkeypatch):
    camera(monkeypatch, PhotographedPlant)
    study = under("rgb", "rgb?p=1", "nudge + rgb?blur=4&occlude=0.3", plant="fast-twin")
    assert practice_plan(study, Experiment()).modality == "rgb"
    assert practice_plan(under("rgb?p=1", plant="fast-twin"), Experiment()).modality == "rgb"
    assert list(shown(study)) == ["rgb"]
    assert shown(study) == shown(under("rgb", plant="fast-twin"))
