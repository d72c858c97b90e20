"""Gates say what the interlock says; pins and blocks leave room at both ends and nowhere between."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lockprobe_robot.box_model.gates import PIN_RADIUS, STROKE, blocks_of, gates_of, pin_of
from lockprobe_robot.box_model.mounted_joint import mounting_choices

from lockprobe.boxes.box import Joint, Lockbox

SIZE = 4
NAMES = tuple("abcd")


def lockbox(interlock):
    joints = tuple(Joint(name=name, kind="prismatic") for name in NAMES)
    return Lockbox(name="drawn", joints=joints, interlock=interlock, initial=(False,) * SIZE, target="a")


def clauses(joint):
    others = [name for name in NAMES if name != joint]
    return st.lists(st.dictionaries(st.sampled_from(others), st.booleans(), max_size=3), min_size=1, max_size=4)


@settings(max_examples=30, deadline=None)
@given(st.fixed_dictionaries({name: clauses(name) for name in NAMES}))
def test_all_gates_stand_open_exactly_when_the_joint_may_move(interlock):
    drawn = lockbox({name: tuple(found) for name, found in interlock.items()})
    gates = gates_of(drawn)
    for configuration in itertools.product((False, True), repeat=SIZE):
        for joint in range(SIZE):
            mine = [gate for gate in gates if gate.joint == joint]
            is_open = all(any(configuration[j] == p for j, p in gate.literals) for gate in mine)
            assert is_open == drawn.may_move(configuration, joint)


def gap(mounted, fraction, out):
    """From the pin's surface, ``out`` of its way, to the nearest block while the joint is at a fraction, metres."""
    (x, y), (ox, oy) = pin_of(mounted)
    point = np.array([x + out * ox, y + out * oy])
    turn = -fraction * mounted.travel if mounted.kind == "revolute" else 0.0
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    if mounted.kind == "revolute":
        point = np.array(mounted.origin) + rotation @ (point - mounted.origin)
    else:
        point = point - (mounted.knob(fraction) - mounted.knob(0))
    distances = []
    for middle, angle, half in blocks_of(mounted):
        along = np.array([math.cos(angle), math.sin(angle)])
        here = point - middle
        beyond = np.abs([here @ along, here @ [-along[1], along[0]]]) - half
        distances.append(np.hypot(*np.maximum(beyond, 0)) + min(max(beyond), 0))
    return min(distances) - PIN_RADIUS


@pytest.mark.parametrize("kind", ["prismatic", "revolute"])
def test_what_joint_and_gate_can_do_together_is_an_h(kind):
    for mounted in mounting_choices(kind, (0.03, 0.02)):
        for out in np.linspace(0, STROKE, 8):
            assert gap(mounted, 0.0, out) > 0.0008, "at position 0 the pin goes in and out"
            assert gap(mounted, 1.0, out) > 0.0008, "at position 1 the pin goes in and out"
        for fraction in np.linspace(0, 1, 41):
            assert gap(mounted, fraction, STROKE) > 0.001, "out of the way, the pin never touches"
        for fraction in np.linspace(0.05, 0.95, 37):
            assert gap(mounted, fraction, 0.0) < 0, "in the way, the pin stands where the block would have to be"
