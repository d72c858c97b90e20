"""Gates say what the interlock says, and pins and blocks do it, whatever is pushed, and nothing else moves."""

import itertools

import numpy as np
import pytest
from box_model.scenes import mechanism_of, two_joints
from hypothesis import given, settings
from hypothesis import strategies as st
from lockprobe_robot.box_model.gates import gates_of

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box, generate
from lockprobe.foundation.errors import PlantFault

KINDS = ("prismatic", "revolute")


def assert_pushed_as_ruled(mechanism, drawn, joint, newtons=30.0):
    after, _ = drawn.attempt(mechanism.configuration(), joint)
    mechanism.push(joint, newtons)
    assert mechanism.configuration() == after
    assert np.abs(mechanism.fractions() - np.array(after)).max() < 0.03


def test_chain_4_from_every_configuration():
    mechanism = mechanism_of(box())
    for configuration, joint in itertools.product(itertools.product((False, True), repeat=4), range(4)):
        mechanism.set_configuration(configuration)
        assert_pushed_as_ruled(mechanism, box(), joint)


@pytest.mark.parametrize(("newtons", "places"), [(10.0, ((0.25, 0.5), (0.75, 0.5))), (100.0, ((0.4, 0.8), (0.6, 0.2)))])
@pytest.mark.parametrize(("locked", "by"), list(itertools.product(KINDS, KINDS)))
def test_every_kind_locks_every_kind(locked, by, places, newtons):
    for asked in (False, True):
        drawn = two_joints(locked, by, clauses=({"b": asked},), places=places)
        mechanism = mechanism_of(drawn)
        for configuration, joint in itertools.product(itertools.product((False, True), repeat=2), range(2)):
            mechanism.set_configuration(configuration)
            assert_pushed_as_ruled(mechanism, drawn, joint, newtons)


@pytest.mark.parametrize("seed", [11, 16])
def test_random_boxes_with_alternatives_pushed_at_random(seed):
    family, layout = f"random-{3 + seed % 6}", ("ngram", "scattered")[seed % 2]
    drawn = generate(family, seed, layout=layout, dealt=True)
    mechanism = mechanism_of(drawn)
    mechanism.set_configuration(drawn.initial)
    for joint in np.random.default_rng(5).integers(len(drawn.joints), size=30):
        assert_pushed_as_ruled(mechanism, drawn, int(joint))


@pytest.mark.parametrize("friction", [0.0, 4.0])
@pytest.mark.parametrize("tilt", [0, 80])
def test_neither_friction_nor_tilt_changes_what_moves(friction, tilt):
    mechanism = mechanism_of(box(), friction=friction, tilt=tilt)
    for joint in (0, 3, 1, 2, 1, 0, 3, 2):
        assert_pushed_as_ruled(mechanism, box(), joint)


def test_more_than_a_box_knows_is_a_fault_and_what_it_knows_is_not():
    mechanism = mechanism_of(box())
    before = (False, False, False, False)
    assert mechanism.configuration_after(3, before) == before
    mechanism.set_configuration((False, False, False, True))
    assert mechanism.configuration_after(3, before) == (False, False, False, True)
    with pytest.raises(PlantFault, match="slider-1 moved revolute-right as well"):
        mechanism.configuration_after(1, before)
    mechanism.data.joint("revolute-right").qpos[0] *= 0.4
    with pytest.raises(
        PlantFault, match=r"more than 8% of its travel from its ends .*revolute-right 0\.40.*less friction"
    ):
        mechanism.configuration_after(3, before)


NAMES = tuple("abcd")


def clauses(joint):
    others = [name for name in NAMES if name != joint]
    return st.lists(st.dictionaries(st.sampled_from(others), st.booleans(), max_size=3), min_size=1, max_size=4)


@settings(max_examples=30, deadline=None)
@given(st.fixed_dictionaries({name: clauses(name) for name in NAMES}))
def test_all_gates_stand_open_exactly_when_the_joint_may_move(interlock):
    joints = tuple(Joint(name=name, kind="prismatic") for name in NAMES)
    ruled = {name: tuple(found) for name, found in interlock.items()}
    drawn = Lockbox(name="drawn", joints=joints, interlock=ruled, initial=(False,) * 4, target="a")
    gates = gates_of(drawn)
    for configuration in itertools.product((False, True), repeat=4):
        for joint in range(4):
            mine = [gate for gate in gates if gate.joint == joint]
            is_open = all(any(configuration[j] == p for j, p in gate.literals) for gate in mine)
            assert is_open == drawn.may_move(configuration, joint)
