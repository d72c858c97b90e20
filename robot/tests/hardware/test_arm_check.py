"""An arm that is held: what is measured, and what is complained of."""

import itertools

import numpy as np
import pytest
from hardware.fakes import StoppableFake
from lockprobe_robot.hardware.arm_check import check_arm

from lockprobe.foundation.errors import PlantFault


def check(arm, takes=(0.01,), commands=50):
    """``takes``: how long commands take, in turn."""
    turns = itertools.cycle(takes)
    ticks = itertools.accumulate(itertools.chain.from_iterable((0.0, next(turns)) for _ in itertools.count()))
    return check_arm(arm, commands=commands, clock=lambda: next(ticks))


def test_an_arm_that_stays_and_answers_may_move():
    found = check(StoppableFake())
    assert found.complaints == ()
    assert (found.commands, found.late, found.success_rate, found.drift) == (50, 0, None, 0.0)
    assert found.latency == pytest.approx((0.01, 0.01, 0.01))


def rated(rate):
    arm = StoppableFake()
    arm.success_rate = rate
    return arm


@pytest.mark.parametrize(
    ("arm", "takes", "complaint"),
    [
        (rated(0.9), (0.01,), "the robot received 90.0% of commands in time, least 95%"),
        (StoppableFake(), (0.01,) * 9 + (0.03,), "5 of 50 commands were late, at most 1%"),
        (StoppableFake(follows=lambda point: point - np.array([0, 0, 0.006])), (0.01,), "the tool drifted by 6.0 mm"),
        (StoppableFake(feel=lambda at, t: np.full(3, 3.0 * np.sign(np.sin(1000 * t)))), (0.01,), "the force varies by"),
    ],
)
def test_what_is_not_good_enough_is_said(arm, takes, complaint):
    (said,) = check(arm, takes).complaints
    assert said.startswith(complaint)


def test_the_first_commands_may_sag():
    """The controller takes over the weight: only what comes after counts."""
    sags = itertools.count()
    arm = StoppableFake(follows=lambda point: point - np.array([0, 0, 0.02 * (next(sags) < 9)]))
    assert check(arm).complaints == ()


def test_too_few_commands_are_refused():
    with pytest.raises(PlantFault, match="at least 10 commands, not 5"):
        check(StoppableFake(), commands=5)
