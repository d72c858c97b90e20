"""The fast twin is a plant whose truth is the symbolic one, with pictures of it."""

import numpy as np
import pytest
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.protocols import Plant

LABELS = tuple("ABCDEFGH")


def twin(name="chain-4", seed=1, drawn=None, **settings):
    drawn = drawn or box(name)
    labels = LABELS[: len(drawn.joints)]
    return FastTwin(drawn, labels=labels, settings=SceneSettings(**settings), rng=np.random.default_rng(seed))


def test_its_truth_is_the_symbolic_one():
    physical, symbolic = twin("random-5-2"), SymbolicPlant(box("random-5-2"))
    assert isinstance(physical, Plant)
    assert physical.observe().configuration == symbolic.observe().configuration
    for joint in np.random.default_rng(3).integers(5, size=40):
        seen, ruled = physical.attempt(int(joint)), symbolic.attempt(int(joint))
        assert (seen.configuration, seen.joint, seen.outcome) == (ruled.configuration, ruled.joint, ruled.outcome)
    physical.close()


def test_pictures_show_the_moment_and_only_that():
    physical = twin(width=160, height=120)
    before = physical.observe()
    first = before.look()
    after = physical.attempt(3)
    second = after.look()
    assert first.rgb.shape == second.rgb.shape == (120, 160, 3)
    assert first.handles.shape == (4, 2, 3)
    changed = np.nonzero((first.rgb != second.rgb).any(2))
    places = second.camera.project(second.handles[3])[:, :2]
    assert places[:, 1].min() - 25 < changed[0].mean() < places[:, 1].max() + 25
    assert places[:, 0].min() - 25 < changed[1].mean() < places[:, 0].max() + 25
    physical.attempt(3)
    with pytest.raises(PlantFault, match="after the next attempt"):
        after.look()
    physical.close()


def test_who_does_not_look_has_the_same_luck():
    looked, blind = (twin(width=64, height=64, depth_noise=0.002) for _ in range(2))
    looked.observe().look()
    for joint in (3, 2, 1):
        assert looked.attempt(joint) == blind.attempt(joint)
    assert (looked._mechanism.fractions() == blind._mechanism.fractions()).all()
