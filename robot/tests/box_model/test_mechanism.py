"""Pins and blocks do what the interlock says, whatever is pushed, and nothing else moves."""

import itertools

import mujoco
import numpy as np
import pytest
from box_model.scenes import mechanism_of, two_joints

from lockprobe.boxes.families import box
from lockprobe.boxes.generate import Recipe, RefusedRecipe, generate
from lockprobe.foundation.errors import PlantFault

KINDS = ("prismatic", "revolute")


def assert_pushed_as_ruled(mechanism, drawn, joint, newtons=30.0):
    before = mechanism.configuration()
    after, moves = drawn.attempt(before, joint)
    assert mechanism.push(joint, newtons) == moves
    assert mechanism.configuration() == after
    assert np.abs(mechanism.fractions() - np.array(after)).max() < 0.03


@pytest.mark.parametrize("kind", ["contact", "ideal"])
def test_chain_4_from_every_configuration(kind):
    mechanism, _, _ = mechanism_of(box(), mechanism=kind)
    for configuration, joint in itertools.product(itertools.product((False, True), repeat=4), range(4)):
        mechanism.set_configuration(configuration)
        assert_pushed_as_ruled(mechanism, box(), joint)


@pytest.mark.parametrize(("newtons", "places"), [(10.0, ((0.25, 0.5), (0.75, 0.5))), (100.0, ((0.4, 0.8), (0.6, 0.2)))])
@pytest.mark.parametrize(("locked", "by"), list(itertools.product(KINDS, KINDS)))
def test_every_kind_locks_every_kind(locked, by, places, newtons):
    for asked in (False, True):
        drawn = two_joints(locked, by, clauses=({"b": asked},), places=places)
        mechanism, _, _ = mechanism_of(drawn)
        for configuration, joint in itertools.product(itertools.product((False, True), repeat=2), range(2)):
            mechanism.set_configuration(configuration)
            assert_pushed_as_ruled(mechanism, drawn, joint, newtons)


@pytest.mark.parametrize("layout", ["ngram", "scattered"])
def test_random_boxes_with_alternatives_pushed_at_random(layout):
    recipes = (
        Recipe(
            family=f"random-{3 + seed % 6}",
            layout=layout,
            dealt=True,
            initial="random",
            alternatives=3,
            literals=3,
            seed=seed,
        )
        for seed in itertools.count(len(layout))
    )
    drawn = next(found for found in map(generate, recipes) if not isinstance(found, RefusedRecipe))
    mechanism, _, _ = mechanism_of(drawn)
    mechanism.set_configuration(drawn.initial)
    for joint in np.random.default_rng(5).integers(len(drawn.joints), size=30):
        assert_pushed_as_ruled(mechanism, drawn, int(joint))


def test_without_pins_nothing_is_locked():
    mechanism, model, _ = mechanism_of(box())
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    assert [mechanism.push(joint) for joint in range(4)] == [True] * 4


def test_a_lost_condition_leaves_joints_at_rest():
    mechanism, _, data = mechanism_of(box())
    mechanism.set_configuration((True, False, False, False))
    for _ in range(500):
        mechanism.step()
    assert mechanism.resting()
    assert np.abs(data.qvel).max() < 1e-4
    assert mechanism.fractions() == pytest.approx([1, 0, 0, 0], abs=0.01)


def test_what_is_half_way_holds_the_joint_that_locks_it():
    drawn = two_joints("prismatic", "prismatic")
    mechanism, _, data = mechanism_of(drawn)
    mechanism.set_configuration((False, True))
    data.joint("joint-0").qpos = 0.04
    assert not mechanism.resting()
    for _ in range(100):
        data.joint("joint-0").qpos, data.joint("joint-0").qvel = 0.04, 0
        data.joint("joint-1").qfrc_applied = -10
        mechanism.step()
    assert mechanism.fractions()[1] > 0.7


def test_a_joint_springs_to_the_end_that_is_nearer():
    mechanism, _, data = mechanism_of(two_joints("prismatic", "revolute", clauses=({},)))
    for fraction, end in ((0.2, 0), (0.8, 1)):
        mechanism.set_configuration((False, False))
        data.joint("joint-0").qpos = fraction * 0.08
        data.joint("joint-1").qpos = fraction * 1.4
        mechanism.settle()
        assert mechanism.fractions() == pytest.approx([end, end], abs=0.01)


def test_the_same_pushes_give_the_same_fractions_bit_by_bit():
    courses = []
    for _ in range(2):
        mechanism, _, _ = mechanism_of(box("branched"), looks="varied")
        mechanism.set_configuration(box("branched").initial)
        course = []
        for joint in np.random.default_rng(2).integers(7, size=25):
            mechanism.push(int(joint))
            course.append(mechanism.fractions().tobytes())
        courses.append(course)
    assert courses[0] == courses[1]


@pytest.mark.parametrize("friction", [0.0, 4.0])
@pytest.mark.parametrize("tilt", [0, 80])
def test_neither_friction_nor_tilt_changes_what_moves(friction, tilt):
    mechanism, _, _ = mechanism_of(box(), friction=friction, tilt=tilt)
    for joint in (0, 3, 1, 2, 1, 0, 3, 2):
        assert_pushed_as_ruled(mechanism, box(), joint)


def test_more_than_a_box_knows_is_a_fault_and_what_it_knows_is_not():
    mechanism, _, data = mechanism_of(box())
    before = (False, False, False, False)
    assert mechanism.configuration_after(3, before) == before
    mechanism.set_configuration((False, False, False, True))
    assert mechanism.configuration_after(3, before) == (False, False, False, True)
    with pytest.raises(PlantFault, match="another joint moved with joint 1: 0000 became 0001"):
        mechanism.configuration_after(1, before)
    data.joint("joint-3").qpos[0] *= 0.4
    with pytest.raises(PlantFault, match=r"joint 3 was attempted in 0000 and .* 0\.00, 0\.00, 0\.00, 0\.40 of"):
        mechanism.configuration_after(3, before)
