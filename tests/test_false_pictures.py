"""False pictures show what is told: they change what is seen, and nothing else."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import TwinSettings
from seen import PhotographedPlant

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.trial.pictures.frame import from_png
from lockprobe.trial.plan import Plan

SMALL = "fast-twin?width=160&height=120"
PLAN = Plan(
    study="s",
    agent="random",
    box=box(),
    condition=flips((0.4,), modalities=("rgb",))[0],
    repetition=1,
    trial=3,
    seed=1,
)


def lived(trial):
    """What was chosen, what was told of it, and what was said."""
    return [(step.decision.joint, step.told_moved, step.told_falsely, step.decision.claimed) for step in trial.steps]


@pytest.mark.parametrize(
    ("told", "modality"),
    [
        ({"p": 0.4, "seed": 1}, "rgb"),
        ({"p": 0.5, "flip": "integrated", "seed": 4}, "rgb"),
        ({"p": 0.5, "flip": "re-observed", "seed": 4}, "rgbd"),
        ({"condition": "drop?p=0.4", "seed": 2}, "rgb"),
        ({"condition": "delay?lag=2", "seed": 3}, "rgb"),
    ],
)
def test_who_sees_well_plays_as_its_strategy_does_that_is_told_the_same_states(told, modality):
    """Whatever becomes of a report becomes of the picture: false, late, or none where nothing is told."""
    words = run_trial(agent="human-inspired", modality="symbolic?tell=state", max_steps=8, **told)
    shown = run_trial(agent="viewer?acuity=64", modality=modality, plant=SMALL, max_steps=8, **told)
    assert lived(shown) == lived(words)
    assert all(step.pictures or (step.told, step.told_moved) == ("", None) for step in shown.steps)
    assert any(step.told_falsely or step.told_state is not None or not step.pictures for step in shown.steps)


def test_pictures_that_are_not_false_are_those_of_the_truth():
    true = run_trial(agent="viewer:random", modality="rgb", plant=SMALL, max_steps=8)
    mixed = run_trial(agent="viewer:random", modality="rgb", p=0.4, plant=SMALL, max_steps=8)
    assert true.actions == mixed.actions
    assert all(step.told_state is None for step in true.steps)
    assert [channel["channel"] for channel in true.channels] == ["CameraChannel"]
    for one, other in zip(true.steps, mixed.steps, strict=True):
        assert (one.pictures == other.pictures) == (other.told_state is None)
    assert {step.told_state is None for step in mixed.steps} == {True, False}


@pytest.mark.parametrize("plant", ["fast-twin", "twin"])
def test_drawing_what_is_not_changes_nothing_that_is(plant):
    source = resolve_plant(f"{plant}?width=96&height=72&depth_noise=0.002")
    honest, lying = (source.make(box(), tuple("ABCD"), np.random.default_rng(5)) for _ in range(2))
    for joint in (None, 3, 0):
        true, told = (one.observe() if joint is None else one.attempt(joint) for one in (honest, lying))
        before = whole_state(lying)
        other = tuple(not position for position in told.configuration)
        first, false = true.look(), told.render(other)
        assert whole_state(lying) == before == whole_state(honest)
        assert (first.rgb != false.rgb).any()
        np.testing.assert_array_equal(first.handles, false.handles)
    np.testing.assert_array_equal(true.look().depth, told.render(told.configuration).depth)
    honest.close(), lying.close()


def whole_state(plant):
    model, data = plant._mechanism.model, plant._mechanism.data
    everything = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, data, state, everything)
    return state.tobytes()


def test_a_false_picture_is_the_picture_of_that_configuration_and_the_arm_stays():
    settings = TwinSettings(width=160, height=120)
    plant = Twin(box(), labels=tuple("ABCD"), settings=settings, rng=np.random.default_rng(2))
    false = plant.observe().render((False, False, False, True)).rgb.astype(int)
    plant.put((False, False, False, True))
    true = plant.observe().look().rgb.astype(int)
    plant.close()
    assert (np.abs(false - true).max(axis=2) > 40).mean() < 0.002


def pictured(plant, channels, plan=PLAN):
    """The percepts of three attempts."""
    names, luck = plan.names, plan.luck
    task, found = names.task, []
    for step, joint in enumerate((None, 3, 0, 0)):
        percept = names.percept(plant.observe() if joint is None else plant.attempt(joint))
        for channel in channels:
            percept = channel.perceive(percept, (), task, luck.at("channel-0", step))
        found.append(percept)
    return found


class Painted(PhotographedPlant):
    """One that can draw what is not."""

    def _with_camera(self, snapshot):
        return replace(super()._with_camera(snapshot), render=self.picture)


def test_a_picture_shows_what_is_told_in_panel_order():
    *_, last = pictured(Painted(PLAN.box), [OutcomeFlip(p=1.0), CameraChannel()])
    assert from_png(last.pictures[0].png)[0, :4, 0].tolist() == [255, 0, 0, 255]
    *_, last = pictured(Painted(PLAN.box), [CameraChannel()])
    assert from_png(last.pictures[0].png)[0, :4, 0].tolist() == [0, 0, 0, 255]


def test_a_plant_that_shows_only_what_is_says_so():
    with pytest.raises(
        BadValue, match="^false picture: got '0000', expected a plant that can draw false pictures: fast-twin"
    ):
        pictured(PhotographedPlant(PLAN.box), [OutcomeFlip(p=1.0), CameraChannel()])
