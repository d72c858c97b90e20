"""The dry run: every motion is made above the board, the box stays as it is, and what is felt or sinks stops the arm."""

import numpy as np
import pytest
from hardware.fakes import SPACE, Breaking, Willing
from lockprobe_robot.arm.guarded_move import GuardedMove
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.hardware.bounds import Bounded, Bounds
from lockprobe_robot.hardware.rehearsal import parts_of
from lockprobe_robot.hardware.rig import Rig

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, PlantFault

CHAIN = box("chain-4")


def rig_of(operator, *, at=10**9, instead=lambda arm: None, **limits):
    path = lay_out_panel(CHAIN).handle_path
    arm = Breaking(CHAIN, path, at=at, instead=instead)
    within = Bounded(arm, Bounds(**{**SPACE, "answer": 60.0, **limits}), operator)
    return Rig(CHAIN, labels=CHAIN.names, arm=within, path=path, operator=operator, truth="person"), arm


def test_every_joint_goes_both_ways_at_its_height_after_a_yes_and_the_box_stays_as_it_is():
    operator, heights, told = Willing(), [], []
    rig, arm = rig_of(operator)
    normal = -lay_out_panel(CHAIN).handle_path(0, False).axis
    board = float(lay_out_panel(CHAIN).handle_path(0, False).points[0] @ normal)
    follow = arm.follow
    arm.follow = lambda position, velocity, *, stiffness: (
        heights.append(float(position @ normal) - board),
        follow(position, velocity, stiffness=stiffness),
    )
    found = rig.dry_run(0.08, told.append)
    assert [(one.joint, one.start) for one in found.motions] == [(name, at) for name in CHAIN.names for at in (0, 1)]
    assert found.motions == tuple(told)
    assert {one.verdict for one in found.motions} == {"moved"}
    assert min(heights) == pytest.approx(0.08)
    assert max(heights) == pytest.approx(0.13, abs=0.003)  # the clearance of the guarded move
    assert arm.configuration == CHAIN.initial
    assert (found.rung, found.facts["rung"], found.complaints) == ("dry-run", "robot", ())
    assert len(operator.questions) == 1
    assert operator.told == ["Dry run: the hand stays 80 mm above the handles and touches nothing."]


def pushed(arm):
    arm.force = lambda: np.array([0.0, 11.0, -6.0])


def sunk(arm):
    where = arm.position
    arm.position = lambda: where() - np.array([0.0, 0.0, 0.06])


@pytest.mark.parametrize(
    ("breaks", "limits", "why"),
    [
        (pushed, {}, "the hand feels 11.0 N where nothing should be, at most 10 N"),
        (sunk, {}, "mm above the handles, expected 100 mm"),
        (lambda arm: None, {"high": (1.0, 1.0, 0.3)}, "lies outside the workspace"),
        (lambda arm: 1 / 0, {}, "ZeroDivisionError"),
    ],
    ids=["touched", "sunk", "workspace", "driver"],
)
def test_what_should_not_be_stops_the_arm(breaks, limits, why):
    rig, arm = rig_of(Willing(), at=20, instead=breaks, **limits)
    with pytest.raises(PlantFault, match=why) as caught:
        rig.dry_run()
    assert "\n" not in str(caught.value)
    assert "stop" in arm.log
    calls = arm._calls
    assert arm.log[-1] == "stop"
    assert calls <= 20  # nothing was commanded after it


def test_without_a_yes_nothing_moves():
    rig, arm = rig_of(Willing("n"))
    with pytest.raises(PlantFault, match="the operator did not agree"):
        rig.dry_run()
    assert (set(arm.log), arm._calls, arm.time) == ({"stop"}, 0, 0.0)


def test_the_hand_is_off_by_what_it_lacks_along_the_path_and_not_where_it_rises():
    rig, arm = rig_of(Willing())
    where, follow, stiff = arm.position, arm.follow, [0.0]

    def noting(position, velocity, *, stiffness):
        stiff[0] = stiffness
        follow(position, velocity, stiffness=stiffness)

    arm.follow = noting
    arm.position = lambda: where() + np.array([0.003 if stiff[0] == GuardedMove().held_stiffness else 0.02, 0.0, 0.0])
    assert [one.astray for one in rig.dry_run().motions] == pytest.approx([0.003] * 8)


@pytest.mark.parametrize("height", [0.01, 0.5, float("nan")])
def test_a_height_at_which_the_hand_would_touch_is_refused(height):
    operator = Willing()
    rig, arm = rig_of(operator)
    with pytest.raises(BadValue, match="metres from 0.05 to 0.3"):
        rig.dry_run(height)
    assert (operator.told, arm.time, arm.log) == ([], 0.0, [])


def test_a_motion_that_does_not_follow_its_way_is_a_complaint():
    rig, arm = rig_of(Willing())
    arm.position = lambda: lay_out_panel(CHAIN).handle_path(0, False).points[0] + np.array([0.0, 0.0, 0.2])
    found = rig.dry_run()
    assert len(found.complaints) == len(found.motions) == 8
    assert found.complaints[0] == "revolute-left from 0: the verdict is failed, in free air it is moved"


def test_the_twins_arm_touches_nothing():
    pytest.importorskip("mujoco")
    chain = box("chain-2")
    parts = parts_of("twin", chain, chain.names, np.random.default_rng(1))
    operator = Willing()
    within = Bounded(parts.arm, Bounds(**SPACE, answer=60.0), operator)
    rig = Rig(chain, labels=chain.names, arm=within, path=parts.path, operator=operator, rung="twin")
    found = rig.dry_run()
    assert found.complaints == ()
    assert max(one.force for one in found.motions) < 5
    assert min(one.lowest for one in found.motions) > 0.09
    assert parts.state() == chain.initial
