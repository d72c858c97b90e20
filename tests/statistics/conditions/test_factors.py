"""Conditions that differ in one option that is no number are compared with each other, as a family of their own."""

from hypothesis import given
from hypothesis import strategies as st

from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.conditions.factors import factor_effects, factors_of
from lockprobe.studies.running.single import run_trial
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


def test_other_conditions_change_no_p_value_and_every_contrast_is_corrected_for_all_of_its_factor():
    specs = ("flip?p=0.2", "flip?p=0.2&others=kept", "flip?p=0.4", STICKY)
    agent = "cognitive:perseverant"
    cells = {
        (agent, spec): [run_trial(agent=agent, condition=spec, trial=i + 1, seed=3) for i in range(12)]
        for spec in specs
    }
    (factor,) = factors_of(arms_of(map(read_condition, specs)))
    found = [make() for make in factor_effects(cells, factor, (agent,))]
    assert [(one.control, one.effects[0].condition, one.agents) for one in found] == [
        ("flip?p=0.2", "flip?p=0.2&others=kept", 2), ("flip?p=0.4", STICKY, 2),
    ]  # fmt: skip
    (beside,) = factors_of(arms_of(map(read_condition, ("nudge", *specs, "truth"))))
    assert [make() for make in factor_effects(cells, beside, (agent,))] == found
