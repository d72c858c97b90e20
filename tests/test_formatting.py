"""Numbers look alike wherever they are read."""

from lockprobe.formatting import NONE, bracketed, minus, p_value, percent, points, range_said, share


def test_what_is_missing_is_a_dash_or_nothing():
    assert {percent(None), percent(float("nan")), bracketed(None, None, None), share(None, 0.0, 0.0)} == {NONE}
    assert range_said(0.1, None) == ""
    assert p_value(None) == "not tested"


def test_minus_signs_are_set_and_hyphens_of_words_stay():
    assert minus("-0.0 to -3 of no-repeat") == "0.0 to \N{MINUS SIGN}3 of no-repeat"
    assert minus("-0", zeros=True) == "\N{MINUS SIGN}0"
    assert points(-0.26) == "\N{MINUS SIGN}26"
    assert bracketed(-0.1, -0.2, 0.04) == "\N{MINUS SIGN}10 [\N{MINUS SIGN}20, +4]"
    assert range_said(-1, 2, "{:+.1f}", 1) == ", 95 % interval \N{MINUS SIGN}1.0 to +2.0"
