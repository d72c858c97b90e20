"""Readings of a wrench: turned into the base's frame, or refused."""

import numpy as np
import pytest
from lockprobe_robot.hardware.wrench import FreshWrench, WrenchReading

from lockprobe.foundation.errors import PlantFault

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


class Fixed:
    def __init__(self, force=(1.0, 2.0, 3.0), age=0.001):
        self.reading = WrenchReading(force=np.array(force), age=age)

    def read(self):
        return self.reading


def test_a_fresh_reading_is_turned_by_sensor_and_flange():
    assert FreshWrench(reader=Fixed()).force(np.eye(3)) == pytest.approx([1, 2, 3])
    assert FreshWrench(reader=Fixed(), turn=QUARTER).force(np.eye(3)) == pytest.approx([-2, 1, 3])
    assert FreshWrench(reader=Fixed(), turn=QUARTER).force(QUARTER) == pytest.approx([-1, -2, 3])


@pytest.mark.parametrize(
    ("reader", "why"),
    [
        (Fixed(age=0.035), "the wrench is 35 ms old, at most 20 ms"),
        (Fixed(age=-1.0), "the wrench is -1000 ms old"),
        (Fixed(age=float("nan")), "the wrench is nan ms old"),
        (Fixed(force=(1.0, float("nan"), 0.0)), "expected three numbers"),
        (Fixed(force=(1.0, 0.0)), "expected three numbers"),
        (object(), "the wrench reader: AttributeError"),
    ],
)
def test_a_stale_or_senseless_reading_is_a_fault(reader, why):
    with pytest.raises(PlantFault) as caught:
        FreshWrench(reader=reader).force(np.eye(3))
    assert str(caught.value).startswith(why) or why in str(caught.value)


def test_the_limit_itself_is_fresh():
    assert FreshWrench(reader=Fixed(age=0.020)).force(np.eye(3)) is not None
