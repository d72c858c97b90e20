"""Conditions that differ in one option that is no number are compared with each other, as a family of their own."""

from hypothesis import given
from hypothesis import strategies as st

from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.conditions.factors import factors_of, no_feedback_factor
from lockprobe.studies.study_design import arms_of

STICKY = "flip?p=0.4&others=kept"


def found_in(*specs, controls=()):
    found = factors_of(arms_of(map(read_condition, specs)), controls)
    return {one.name: one.groups for one in found}


def test_the_level_that_does_not_say_the_option_is_the_first():
    assert found_in("truth", STICKY, "flip?p=0.4", "nudge") == {"flip others": (("flip?p=0.4", STICKY),)}


def test_every_context_is_a_group_of_the_same_factor():
    beside = [f"{spec} + nudge" for spec in ("flip?p=0.4", STICKY)]
    more = ["flip?p=0.2", "flip?p=0.2&others=kept"]
    assert found_in("flip?p=0.4", STICKY, *beside, *more) == {
        "flip others": (("flip?p=0.4", STICKY), tuple(beside), tuple(more))
    }


def test_what_a_control_is_compared_with_already_is_left_out():
    both = ["drop?p=0.4&luck=flip", "drop?p=0.4"]
    assert found_in(*both) == {"drop luck": (("drop?p=0.4", "drop?p=0.4&luck=flip"),)}
    assert found_in(*both, controls=("drop?p=0.4",)) == {}


@given(st.permutations(["truth", "flip?p=0.4", STICKY, "nudge", "flip?p=0.4 + nudge", f"{STICKY} + nudge"]))
def test_the_order_of_conditions_changes_no_contrast(specs):
    (groups,) = found_in(*specs).values()
    assert {*groups} == {("flip?p=0.4", STICKY), ("flip?p=0.4 + nudge", f"{STICKY} + nudge")}


def test_every_condition_of_flips_alone_is_compared_with_one_that_withholds_every_report():
    none, flips = "drop?p=1", ["flip?p=0.2", "flip?p=0.4"]
    (found,) = no_feedback_factor(arms_of(map(read_condition, ["truth", *flips, "flip?p=0.4 + nudge", none])))
    assert (found.name, found.groups) == ("no feedback", ((none, *flips),))
    for less in (["truth", *flips, "drop?p=0.9"], ["truth", none], ["truth", *flips, "drop?p=1&luck=flip"]):
        assert no_feedback_factor(arms_of(map(read_condition, less))) == []
