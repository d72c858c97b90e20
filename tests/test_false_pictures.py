"""False pictures show what is told: they change what is seen, and nothing else."""

import asyncio
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from drawn_board import HANDLES, HEIGHT, WIDTH, board, deep
from seen import PhotographedPlant

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.modality import interventions_for
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.plan import Plan


class Board(PhotographedPlant):
    """One whose pictures can be read, also of what is not: a drawn board, seen from the front."""

    CAMERA = Camera(width=WIDTH, height=HEIGHT, focal=300.0, panel=np.diag([1.0, -1, -1, 1]))
    CAMERA.panel[2, 3] = 0.72

    def _with_camera(self, snapshot):
        return replace(super()._with_camera(snapshot), render=self.picture)

    def picture(self, configuration):
        seen = np.array(HANDLES[: len(configuration)]) - [(WIDTH - 1) / 2, (HEIGHT - 1) / 2]
        top = np.full((len(configuration), 2, 1), 0.05)
        handles = np.concatenate([seen * [1, -1] * 0.67 / 300, top], axis=-1)
        drawn = (*configuration, False)  # the board has a handle more
        depth = deep(drawn)
        return Frame(rgb=board(drawn), depth=depth, camera=self.CAMERA, handles=handles, renderer="drawn")


def played(agent, spec, seed, kind=Board):
    plan = Plan(
        study="s", agent="random", box=box(), condition=read_condition(spec), repetition=1, trial=1, seed=seed, budget=8
    )
    channels = interventions_for(plan.condition)
    return asyncio.run(play(plan, plant=lambda: kind(plan.box), interventions=channels, agent=resolve(agent).make()))


def lived(trial):
    """What was chosen, what was told of it, and what was said."""
    return [(step.decision.joint, step.told_moved, step.told_falsely, step.decision.claimed) for step in trial.steps]


@pytest.mark.parametrize(
    ("told", "modality", "seed"),
    [
        ("flip?p=0.5&others=kept", "rgb", 4), ("flip?p=0.5", "rgbd", 4), ("drop?p=0.4", "rgb", 2), ("delay?lag=2", "rgb", 3),
    ],
)  # fmt: skip
def test_who_sees_well_plays_as_its_strategy_does_that_is_told_the_same_states(told, modality, seed):
    """Whatever becomes of a report becomes of the picture: false, late, or none where nothing is told."""
    words = played("human-inspired", f"{told} + symbolic?tell=state", seed)
    shown = played("viewer?acuity=64", f"{told} + {modality}", seed)
    assert lived(shown) == lived(words)
    assert all(step.pictures or (step.told, step.told_moved) == ("", None) for step in shown.steps)
    assert any(step.told_falsely or step.told_state is not None or not step.pictures for step in shown.steps)


def test_pictures_that_are_not_false_are_those_of_the_truth():
    true, mixed = (played("viewer:random", condition, 1) for condition in ("rgb", "flip?p=0.4 + rgb"))
    assert true.actions == mixed.actions
    assert all(step.told_state is None for step in true.steps)
    assert [channel["channel"] for channel in true.channels] == ["CameraChannel"]
    for one, other in zip(true.steps, mixed.steps, strict=True):
        assert (one.pictures == other.pictures) == (other.told_state is None)
    assert {step.told_state is None for step in mixed.steps} == {True, False}


@pytest.mark.parametrize("plant", ["fast-twin", "twin"])
def test_a_false_picture_is_that_of_its_configuration_and_changes_nothing_that_is(plant):
    one = resolve_plant(f"{plant}?width=96&height=72").make(box(), tuple("ABCD"), np.random.default_rng(5))
    start = one.observe()
    before, false = whole_state(one), start.render((False, False, False, True))
    first = start.look()
    assert whole_state(one) == before
    np.testing.assert_array_equal(first.depth, start.render(start.configuration).depth)
    seen = one.attempt(3)
    assert seen.configuration == (False, False, False, True)
    true = seen.look()
    assert (first.rgb != true.rgb).any()
    np.testing.assert_array_equal(first.handles, false.handles)
    assert (np.abs(false.rgb.astype(int) - true.rgb).max(axis=2) > 40).mean() < 0.01
    one.close()


def whole_state(plant):
    model, everything = plant.joints.model, mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, everything))
    mujoco.mj_getState(model, plant.joints.data, state, everything)
    return state.tobytes()


def test_a_plant_that_shows_only_what_is_says_so():
    with pytest.raises(
        BadValue, match="^false picture: got '[01]{4}', expected a plant that can draw false pictures: fast-twin"
    ):
        played("random", "flip?p=1 + rgb", 1, PhotographedPlant)
