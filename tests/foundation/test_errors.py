"""Errors in one line: what was asked, and what exists."""

from lockprobe.foundation.errors import UnknownName


def test_an_unknown_name_comes_with_those_that_exist():
    assert (
        str(UnknownName("trial", "b", ["a", "bc"])) == "no trial is called 'b' (did you mean 'bc'?); there are: a, bc"
    )
    assert str(UnknownName("trial", "x", [])) == "no trial is called 'x'; there is none"
