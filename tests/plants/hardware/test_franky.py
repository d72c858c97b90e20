"""The real client library against a simulated robot over loopback; skipped where they are not installed."""

import time

import numpy as np
import pytest

pytest.importorskip("franky")
pytest.importorskip("franky_sim")

from lockprobe.errors import PlantFault
from lockprobe.lockbox.families import box
from lockprobe.plants.arm.guarded_move import GuardedMove
from lockprobe.plants.hardware.bounds import Bounded, Bounds
from lockprobe.plants.hardware.rehearsal import BOUNDS, parts_of
from lockprobe.plants.operator import ConsentingOperator

CHAIN = box("chain-4")
STILL = np.zeros(3)


@pytest.fixture
def parts():
    found = parts_of("wire", CHAIN, tuple("ABCD"), np.random.default_rng(1))
    yield found
    found.close()


def test_a_free_and_a_locked_joint_over_the_wire(parts):
    arm = Bounded(parts.arm, BOUNDS, ConsentingOperator())
    arm.home()
    for joint, verdict, after in ((3, "moved", (0, 0, 0, 1)), (0, "blocked", (0, 0, 0, 1))):
        touch = GuardedMove().attempt(arm, parts.path(joint, False))
        assert (touch.verdict, parts.state()) == (verdict, tuple(map(bool, after)))
    assert parts.arm.success_rate == 1.0
    assert parts.facts["driver"] == "franky-control 2.0.0"


def robot_of(parts):
    """The process behind the parts."""
    return parts.put.__self__


FAULTS = {
    "server killed": (lambda parts: robot_of(parts).process.kill(), {}, "the arm, |the wrench is"),
    "frozen for 1 s": (lambda parts: robot_of(parts).freeze(1.0), {"answer": 0.3}, "the wrench is|no answer within"),
    "frozen for 60 s": (lambda parts: robot_of(parts).freeze(60.0), {"answer": 0.3}, "the wrench is|no answer within"),
    "motion ended": (lambda parts: parts.arm._robot.stop(), {}, "the robot ended the motion"),
}


@pytest.mark.parametrize(("breaks", "limits", "why"), FAULTS.values(), ids=FAULTS)
def test_a_fault_on_the_wire_stops_the_arm_and_is_one_line_soon(parts, breaks, limits, why):
    arm = Bounded(
        parts.arm, Bounds(**{"low": BOUNDS.low, "high": BOUNDS.high, "answer": 2.0, **limits}), ConsentingOperator()
    )
    arm.home()
    start, _ = parts.path(3, False).at(0.0)
    above = start - 0.05 * parts.path(3, False).axis
    arm.reach(above, parts.path(3, False).axis)
    arm.follow(above, STILL, stiffness=2500)
    breaks(parts)
    began = time.monotonic()

    def hold():
        while time.monotonic() - began < 20:
            arm.follow(above, STILL, stiffness=2500)

    with pytest.raises(PlantFault, match=why) as caught:
        hold()
    assert time.monotonic() - began < 10
    assert "\n" not in str(caught.value)
    assert arm.stops == 1
    assert [line for line in arm.log.last if '"stop"' in line]
