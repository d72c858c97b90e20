"""The fast twin is a plant whose truth is the symbolic one, with pictures of it."""

from dataclasses import replace

import numpy as np
import pytest
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, PlantFault
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


def test_a_box_starts_where_it_says():
    assert twin(drawn=replace(box(), initial=(False, True, False, True))).observe().configuration == (
        (False, True, False, True)
    )


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


HARD = {
    "discs": False, "board": "bare", "labels": False, "handle_colours": "plain", "light": "side", "colours": "drawn",
    "viewpoint": "oblique", "handle_shape": "ball", "clutter": 9, "view_jitter": 5.0, "view_turn": 1.0,
}  # fmt: skip


def test_what_makes_pictures_hard_changes_nothing_of_the_physics():
    plain, hard = twin("random-5-2"), twin("random-5-2", **HARD)
    for joint in np.random.default_rng(3).integers(5, size=12):
        assert plain.attempt(int(joint)) == hard.attempt(int(joint))
        assert plain._joints.data.qpos.tobytes() == hard._joints.data.qpos.tobytes()


@pytest.mark.slow
def test_every_part_of_it_changes_the_picture_and_no_luck_of_depth():
    size = {"width": 64, "height": 64}
    usual = twin(**size).observe().look()
    for option, value in HARD.items():
        assert (twin(**size, **{option: value}).observe().look().rgb != usual.rgb).any(), option
    noises = []
    for options in ({}, {"clutter": 9, "board": "bare", "colours": "drawn"}):
        noisy, clean = (twin(**size, **options, depth_noise=noise).observe().look().depth for noise in (0.01, 0.0))
        noises.append(np.where((noisy > 0) & (clean > 0), (noisy - clean) / clean.clip(0.1) ** 2, np.nan))
    assert np.nanstd(noises[0]) > 0.01
    assert np.nanquantile(np.abs(noises[0] - noises[1]), 0.9) < 0.003


def test_facts_name_settings_engine_and_what_made_the_pictures():
    physical = twin(width=64, height=64, tilt=25.0)
    assert physical.facts["tilt"] == 25.0
    assert str(physical.facts["engine"]).startswith("mujoco ")
    assert physical.facts["renderer"] is None
    physical.observe().look()
    assert str(physical.facts["renderer"]).startswith("egl")
    physical.close()


def test_a_mechanism_that_breaks_is_a_fault_of_the_plant():
    physical = twin()

    def shaken(joint, newtons):
        physical._mechanism.set_configuration((False, False, True, False))
        return False

    physical._mechanism.push = shaken
    with pytest.raises(PlantFault, match="another joint moved with joint 0: 0000 became 0010"):
        physical.attempt(0)


def test_what_cannot_be_built_is_refused():
    with pytest.raises(BadValue, match="interlock of slider-1"):
        twin(drawn=replace(box(), interlock={"slider-1": ()}))
