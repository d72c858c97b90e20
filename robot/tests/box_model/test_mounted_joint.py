"""Where a handle is along its travel."""

import math

import numpy as np
import pytest
from lockprobe_robot.box_model.mounted_joint import LEVER, SLIDE, SWING, mounting_choices

KINDS = ("prismatic", "revolute")


@pytest.mark.parametrize("kind", KINDS)
def test_the_tangent_is_where_the_handle_goes(kind):
    for mounted in mounting_choices(kind, (0.1, -0.05)):
        for fraction in (0.0, 0.3, 1.0):
            step = (mounted.knob(fraction + 1e-6) - mounted.knob(fraction - 1e-6)) / 2e-6
            assert step / np.hypot(*step) == pytest.approx(mounted.tangent(fraction), abs=1e-6)
            assert np.hypot(*step) == pytest.approx(mounted.length, rel=1e-6)


def test_a_slider_goes_straight_and_a_lever_round_its_pivot():
    for slider in mounting_choices("prismatic", (0.0, 0.0)):
        assert np.hypot(*(slider.knob(1) - slider.knob(0))) == pytest.approx(SLIDE)
        assert slider.knob(0.5) == pytest.approx((slider.knob(0) + slider.knob(1)) / 2)
    for lever in mounting_choices("revolute", (0.0, 0.0)):
        arms = [lever.knob(fraction) - np.array(lever.origin) for fraction in (0, 0.5, 1)]
        assert [np.hypot(*arm) for arm in arms] == pytest.approx([LEVER] * 3)
        turned = math.atan2(arms[0][0] * arms[2][1] - arms[0][1] * arms[2][0], arms[0] @ arms[2])
        assert turned == pytest.approx(SWING)


@pytest.mark.parametrize("kind", KINDS)
def test_the_preferred_fitting_lies_around_its_place(kind):
    first = mounting_choices(kind, (0.2, 0.1))[0]
    assert np.hypot(*(first.room().mean(0) - (0.2, 0.1))) < 0.02
