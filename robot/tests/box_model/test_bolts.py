"""Bolts follow the joints that they are geared to, and sprung ones whoever lifts them."""

import itertools

import pytest
from box_model.scenes import mechanism_of, scene_of, two_joints
from lockprobe_robot.box_model.bolts import case_depth
from lockprobe_robot.box_model.gates import MAX_GATES, STROKE, Gate

from lockprobe.boxes.families import box

EITHER = two_joints("revolute", "prismatic")


def test_a_geared_bolt_is_out_where_its_joint_stands_as_asked():
    for asked in (False, True):
        mechanism, _, data = mechanism_of(two_joints("prismatic", "revolute", clauses=({"b": asked},)))
        for fraction in (0.0, 0.4, 1.0):
            mechanism.set_configuration((False, False))
            data.joint("joint-1").qpos = fraction * 1.4
            data.joint("bolt-0").qpos = STROKE * (fraction if asked else 1 - fraction)
            mechanism.step()
            gap = data.joint("bolt-0").qpos[0] - STROKE * (
                data.joint("joint-1").qpos[0] / 1.4 if asked else 1 - data.joint("joint-1").qpos[0] / 1.4
            )
            assert abs(gap) < 1e-4


def test_any_lifter_lifts_a_sprung_bolt_and_without_one_it_falls():
    mechanism, _, data = mechanism_of(box("common-cause-4"))
    gate = next(g for g in scene_of(box("common-cause-4")).gates if len(g.literals) == 3)
    number = scene_of(box("common-cause-4")).gates.index(gate)
    for lifted in itertools.product((False, True), repeat=3):
        configuration = [False] * 5
        for (joint, position), wanted in zip(gate.literals, lifted, strict=True):
            configuration[joint] = position == wanted
        mechanism.set_configuration(tuple(configuration))
        for _ in range(150):
            mechanism.step()
        place = data.joint(f"bolt-{number}").qpos[0]
        assert place == pytest.approx(STROKE + 0.001 if any(lifted) else 0.0, abs=5e-4)
        assert mechanism.resting()


def test_the_case_is_as_deep_as_its_layers_and_never_too_deep():
    single, either = Gate(joint=0, literals=((1, True),)), Gate(joint=0, literals=((1, True), (2, True)))
    assert case_depth([]) < case_depth([single] * 4) < case_depth([either] * 4) <= case_depth([either] * MAX_GATES)
    assert case_depth([either] * MAX_GATES) < 0.2
