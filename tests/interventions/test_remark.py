"""A sentence that says nothing, at the moments of the nudge or before every step."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.nudge import NUDGE
from lockprobe.interventions.remark import REMARK, Remark
from lockprobe.studies.running.single import run_trial


def test_it_is_as_long_as_the_nudge():
    assert abs(len(NUDGE) - len(REMARK)) <= 4


def test_with_0_it_is_said_before_every_step_but_the_first():
    steps = run_trial(agent="round-robin", box="chain-7", condition="remark?after=0").steps
    assert [step.remark for step in steps] == ["", *[REMARK] * (len(steps) - 1)]


def test_one_copy_is_no_loop():
    with pytest.raises(BadValue, match="a number of copies from 2, or 0 for always"):
        Remark(after=1)
