"""A trial has the same name and the same metadata in an eval and in an export."""

import pytest
from builders import play_study, small_study

samples = pytest.importorskip("lockprobe.interfaces.inspect.samples")


def test_a_plan_and_its_trial_are_the_same_sample():
    study = small_study(["random"], trials=1)
    for plan, trial in zip(study.plans("random"), play_study(study), strict=True):
        assert samples.sample_id(plan) == samples.sample_id(trial)
        assert samples.metadata_of(plan) == samples.metadata_of(trial)
    assert samples.sample_id(trial) == "flip?p=0.6/rep=2/trial=1"
    assert samples.metadata_of(trial)["condition"] == "flip?p=0.6"
