"""The guarded move on a scripted arm: every verdict, every threshold."""

from dataclasses import replace

import numpy as np
import pytest
from arm.fake_arm import FakeArm
from lockprobe_robot.arm import guarded_move as module
from lockprobe_robot.arm.guarded_move import CLEARANCE, HandlePath, guarded_move

AXIS = np.array([0.0, 0.0, -1.0])
START, END = np.array([0.5, 0.0, 0.2]), np.array([0.5, 0.08, 0.2])
PATH = HandlePath(points=np.linspace(START, END, 9), axis=AXIS)
WEIGHT = np.array([0.3, -0.2, -6.0])


def resists_from(place, newtons):
    """A handle that resists from a place on the path on with a constant force."""
    return lambda at, time: WEIGHT + (np.array([0.0, -newtons, 0.0]) if at[1] > place else 0)


def held_at(place, give=0.2):
    """A tool that comes along to a place on the path, and from there on by a share of the way only."""
    return lambda point: np.array([point[0], min(point[1], place + give * (point[1] - place)), point[2]])


def knocks(seconds):
    """A handle that resists for some seconds when the tool first gets so far."""
    began = []

    def feel(at, time):
        if at[1] > 0.02 and not began:
            began.append(time)
        return WEIGHT + (np.array([0.0, -14.0, 0.0]) if began and time - began[0] < seconds else 0)

    return feel


THRESHOLDS = {
    "held by less than counts, the hand comes too short": (resists_from(0.01, 9.5), held_at(0.01, give=0.4), "failed"),
    "held by enough": (resists_from(0.01, 10.5), held_at(0.01, give=0.4), "blocked"),
    "a knock is not a hold": (knocks(0.04), held_at(0.02), "failed"),
    "a long knock is": (knocks(0.2), held_at(0.02), "blocked"),
    "held half way": (resists_from(0.038, 30.0), held_at(0.04), "blocked"),
    "a handle that moved holds at the end of its travel, too": (resists_from(0.066, 30.0), held_at(0.068), "moved"),
    "what the hand weighs is taken off": (lambda at, time: WEIGHT - [0.0, 20.0, 0.0], lambda point: point, "moved"),
}


@pytest.mark.parametrize(("feel", "follows", "verdict"), THRESHOLDS.values(), ids=THRESHOLDS)
def test_a_verdict_turns_at_a_threshold_and_what_holds_is_let_go_at_once(feel, follows, verdict):
    arm = FakeArm(feel=feel, follows=follows)
    touch = guarded_move(arm, PATH)
    assert touch.verdict == verdict
    if verdict == "blocked":
        assert max(point[1] for point, _ in arm.drawn) < touch.progress * PATH.length + 0.02


def test_a_hand_that_lands_on_something_goes_up_and_home_and_has_failed():
    def feel(at, time):
        return WEIGHT + (np.array([0.0, 0.0, 25.5]) if at[2] < 0.22 else 0)

    arm = FakeArm(feel=feel)
    touch = guarded_move(arm, PATH)
    assert (touch.verdict, touch.peak_force, touch.progress) == ("failed", 0.0, 0.0)
    assert arm.position()[2] > 0.22
    assert all(point[1] == 0 for point, _ in arm.drawn)
    assert arm.log[-1] == "home"


def test_the_order_of_things_and_a_way_that_is_smooth_and_never_faster_than_it_may_be():
    arm = FakeArm(feel=resists_from(0.01, 5.0))
    touch = guarded_move(arm, PATH)
    assert touch.progress == pytest.approx(1 + module._OVERDRIVE / PATH.length)
    assert touch.peak_force == pytest.approx(5.0, abs=0.1)
    assert (arm.log[0], set(arm.log[1:-1]), arm.log[-1]) == ("reach", {"follow"}, "home")
    points, velocities = (np.array(drawn) for drawn in zip(*arm.drawn, strict=True))
    assert points[0] == pytest.approx(START - CLEARANCE * AXIS)
    assert points[:, 2].min() == pytest.approx(0.2, abs=1e-3)
    assert points[:, 1].max() == pytest.approx(0.08 + module._OVERDRIVE)
    assert points[-1][2] > 0.2 + 0.9 * CLEARANCE
    assert (touch.seconds, arm.time) == (pytest.approx(4.21), pytest.approx(4.21))
    third = replace(touch, peak_force=1 / 3).as_facts()
    assert (third["verdict"], third["peak_force"], third["progress"]) == ("moved", 0.333333, 1.075)
    speeds = np.linalg.norm(velocities, axis=1)
    assert speeds.max() <= module._DESCENT + 1e-9
    assert np.diff(speeds).max() <= module._LIFT_RAMP * arm.period + 1e-9
    assert np.linalg.norm(np.diff(points, axis=0) - arm.period * velocities[:-1], axis=1).max() < 1e-3


def test_a_point_beside_a_bent_path_has_travelled_as_far_as_the_nearest_one_on_it():
    turns = np.linspace(0, np.pi / 2, 33)
    bent = HandlePath(points=0.1 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1), axis=AXIS)
    for distance in (-0.02, 0.0, 0.05, 0.1, bent.length, bent.length + 0.02):
        point, direction = bent.at(distance)
        beside = np.cross(direction, AXIS)
        assert [bent.travelled(point + off * beside) for off in (0.0, 0.01)] == pytest.approx([distance] * 2, abs=2e-3)
