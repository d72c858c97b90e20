"""Numbers look alike wherever they are read."""

import pytest

from lockprobe.foundation.formatting import NONE, bracketed, change, minus, p_value, percent, points, range_said, share


def test_what_is_missing_is_a_dash_or_nothing():
    assert {percent(None), percent(float("nan")), bracketed(None, None, None), share(None, 0.0, 0.0)} == {NONE}
    assert range_said(0.1, None) == ""
    assert p_value(None) == "not tested"


@pytest.mark.parametrize("end", [-0.0, 0.0, -0.004, 0.004])
def test_an_end_that_rounds_to_0_has_no_sign_anywhere(end):
    assert points(end) == "0"
    assert bracketed(end, end, 0.4) == "0 [0, +40]"
    assert range_said(end, 0.4) == ", 95 % interval 0 to +40"
    assert change(0.4, end, 0.5) == "+40 points, 95 % interval 0 to +50"
    assert bracketed(end, -0.06, end, "{:+.1f}", 1) == "0.0 [\N{MINUS SIGN}0.1, 0.0]"


def test_minus_signs_are_set_and_hyphens_of_words_stay():
    assert minus("-0.0 to -3 of no-repeat") == "0.0 to \N{MINUS SIGN}3 of no-repeat"
    assert points(-0.26) == "\N{MINUS SIGN}26"
    assert bracketed(-0.1, -0.2, 0.04) == "\N{MINUS SIGN}10 [\N{MINUS SIGN}20, +4]"
    assert range_said(-1, 2, "{:+.1f}", 1) == ", 95 % interval \N{MINUS SIGN}1.0 to +2.0"
