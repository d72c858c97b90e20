"""Boxes beside those of the study are told truly, and are the same for everybody."""

from seated import people_study, short

from lockprobe.people.experiment import Experiment
from lockprobe.people.practice import practice_plan


def test_the_practice_is_another_box_with_true_reports_for_everybody_the_same():
    study = people_study(p=(0.4,), layout="shuffled", max_steps=9)
    plan = practice_plan(study, Experiment(practice="chain-2"))
    assert (plan.p, plan.box.name, plan.budget, plan.modality) == (0.0, "chain-2", 9, study.modalities[0])
    assert plan == practice_plan(study, Experiment(practice="chain-2"))
    assert plan.seed != study.seed
    assert practice_plan(study, short()) is None
    pictured = people_study(p=(0.0,), plant="fast-twin", modalities=("rgb",))
    assert practice_plan(pictured, Experiment()).modality == "rgb"
