"""A plant that a condition changes: the same luck, and the same steps as in a study that has that plant."""

from dataclasses import replace

from lockprobe import run_trial, study
from lockprobe.trial.condition import Condition

SHORT = {"agent": "human-inspired", "max_steps": 2, "seed": 3}


def test_a_change_of_the_plant_plays_as_a_study_with_that_plant_does():
    plain = run_trial(plant="twin?pose_error=0.03", **SHORT)
    missing = run_trial(plant="twin", condition="plant?pose_error=0.03", **SHORT)
    assert missing.steps == plain.steps
    assert missing.plant == plain.plant
    assert missing.doses == {"plant.pose_error": 0.03}
    as_plain = {"key": plain.key, "condition": plain.condition, "specs": (), "doses": {}}
    assert replace(missing, **as_plain) == plain
    perfect = run_trial(plant="twin", **SHORT)
    assert (perfect.labels, perfect.listing) == (plain.labels, plain.listing)
    assert [step.sensed for step in perfect.steps] != [step.sensed for step in plain.steps]


def test_a_value_that_the_plant_has_anyway_is_the_plan_of_the_truth():
    plain, same = (
        study(
            "flips", agent="random", p=[0.0], plant="twin?pose_error=0.03", condition=condition, trials=1, repetitions=1
        )
        for condition in ("nudge", ["same=plant?pose_error=0.030", "nudge"])
    )
    assert [one.label for one in same.conditions] == ["same", "nudge"]
    named = next(same.plans("random"))
    assert replace(named, condition=Condition()) == next(plain.plans("random"))
    assert [same.record_identity(one) for one in same.conditions] == list(map(plain.record_identity, plain.conditions))
