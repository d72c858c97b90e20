"""The guarded move on a scripted arm: every verdict, every threshold."""

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


def test_a_handle_that_comes_along_has_moved():
    touch = guarded_move(FakeArm(feel=resists_from(0.01, 5.0)), PATH)
    assert touch.verdict == "moved"
    assert touch.progress == pytest.approx(1 + module._OVERDRIVE / PATH.length)
    assert touch.peak_force == pytest.approx(5.0, abs=0.1)


def test_a_handle_that_holds_is_blocked_and_is_let_go_at_once():
    arm = FakeArm(feel=resists_from(0.01, 15.0), follows=held_at(0.01))
    touch = guarded_move(arm, PATH)
    assert touch.verdict == "blocked"
    assert touch.progress < 0.4
    assert max(point[1] for point, _ in arm.drawn) < 0.03


@pytest.mark.parametrize(("newtons", "verdict"), [(9.5, "failed"), (10.5, "blocked")])
def test_the_threshold_of_force(newtons, verdict):
    """What is not held by more than it does not count as held, and the hand is then seen to come too short."""
    arm = FakeArm(feel=resists_from(0.01, newtons), follows=held_at(0.01, give=0.4))
    assert guarded_move(arm, PATH).verdict == verdict


@pytest.mark.parametrize(("seconds", "verdict"), [(0.04, "failed"), (0.2, "blocked")])
def test_a_knock_is_not_a_hold(seconds, verdict):
    began = None

    def feel(at, time):
        nonlocal began
        if at[1] > 0.02 and began is None:
            began = time
        knocking = began is not None and time - began < seconds
        return WEIGHT + (np.array([0.0, -14.0, 0.0]) if knocking else 0)

    assert guarded_move(FakeArm(feel=feel, follows=held_at(0.02)), PATH).verdict == verdict


@pytest.mark.parametrize(("place", "verdict"), [(0.5, "blocked"), (0.85, "moved")])
def test_force_counts_only_until_enough_has_been_travelled(place, verdict):
    """At the end of its travel a handle that moved holds, too."""
    arm = FakeArm(feel=resists_from(place * 0.08 - 0.002, 30.0), follows=held_at(place * 0.08))
    assert guarded_move(arm, PATH).verdict == verdict


def test_a_hand_that_lands_on_something_goes_up_and_home_and_has_failed():
    def feel(at, time):
        return WEIGHT + (np.array([0.0, 0.0, 40.0]) if at[2] < 0.22 else 0)

    arm = FakeArm(feel=feel)
    touch = guarded_move(arm, PATH)
    assert (touch.verdict, touch.peak_force, touch.progress) == ("failed", 0.0, 0.0)
    assert arm.position()[2] > 0.22
    assert all(point[1] == 0 for point, _ in arm.drawn)
    assert arm.log[-1] == "home"


def test_what_the_hand_weighs_and_what_presses_before_the_drag_are_taken_off():
    bias = np.array([0.0, -20.0, 0.0])
    assert guarded_move(FakeArm(feel=lambda at, time: bias + WEIGHT), PATH).verdict == "moved"


def test_the_order_of_things_and_a_way_that_is_smooth_and_never_faster_than_it_may_be():
    arm = FakeArm()
    touch = guarded_move(arm, PATH)
    assert (arm.log[0], set(arm.log[1:-1]), arm.log[-1]) == ("reach", {"follow"}, "home")
    points, velocities = (np.array(drawn) for drawn in zip(*arm.drawn, strict=True))
    assert points[0] == pytest.approx(START - CLEARANCE * AXIS)
    assert points[:, 2].min() == pytest.approx(0.2, abs=1e-3)
    assert points[:, 1].max() == pytest.approx(0.08 + module._OVERDRIVE)
    assert points[-1][2] > 0.2 + 0.9 * CLEARANCE
    assert touch.seconds == pytest.approx(arm.time)
    assert np.linalg.norm(velocities, axis=1).max() <= module._DESCENT + 1e-9
    assert np.linalg.norm(np.diff(points, axis=0) - arm.period * velocities[:-1], axis=1).max() < 1e-3
