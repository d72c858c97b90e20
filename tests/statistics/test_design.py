"""The design of a study, from specs alone: every contrast has one family; doses, crossings and factors."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import read_condition, sweep
from lockprobe.report.prose import at_dose, cause
from lockprobe.statistics.design import crossed_of, factors_of, series_of, series_of_agents
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study import Study, arms_of, design_of
from lockprobe.trial.condition import Condition

TRUTH = Condition()
FLIPS = [read_condition(f"flip?p={p}") for p in (0.2, 0.4, 0.8)]
OTHERS = [
    read_condition(spec)
    for spec in (
        "nudge", "tremble?p=0.1", "tremble?p=0.3", "drop?p=0.5", "flip?p=0.4 + nudge", "flip?p=0.4&others=kept",
        "flip?p=0.4&at=3", "drop?p=0.5 + tremble?p=0.1",
    )
]  # fmt: skip
_CHANGES = "pose_error=0.01", "pose_error=0.02", "friction=0.3", "looks=varied", "tilt=30&friction=2"
HANDS = [read_condition(f"plant?{options}", plant="twin") for options in _CHANGES]
OTHERS += HANDS
SHOWN = "symbolic?tell=state"


def designed(conditions, agents=("random",)):
    return design_of(Study(name="lab", agents=agents, boxes=(box(),), conditions=tuple(conditions), plant="twin"))


def dosed(comparison):
    return {label for axis in comparison.axes for label in axis.doses} - {comparison.control}


chosen = st.tuples(
    st.lists(st.sampled_from(FLIPS), unique_by=lambda one: one.label),
    st.lists(st.sampled_from(OTHERS), unique_by=lambda one: one.label),
)


@pytest.mark.parametrize(("specs", "control"), [(("nudge", "flip?p=0"), "flip?p=0"), (("nudge", "warn"), "nudge")])
def test_the_control_is_the_truth_or_else_the_first(specs, control):
    assert designed(map(read_condition, specs)).controls == {control}


@given(chosen)
def test_every_condition_but_the_control_is_in_one_family(both):
    flips, others = both
    found = designed([TRUTH, *flips, *others]).comparisons[SHOWN]
    assert found.control == "truth"
    every = [*found.flips, *dosed(found), *found.others]
    assert sorted(every) == sorted(one.label for one in (*flips, *others))


@given(chosen, st.sampled_from([*FLIPS, *OTHERS]))
def test_a_condition_more_changes_no_other_family(both, more):
    flips, others = both
    if more in (*flips, *others) or not flips:  # the first flip that acts says of which kind the axis is
        return
    before = designed([TRUTH, *flips, *others]).comparisons[SHOWN]
    now = designed([TRUTH, *flips, *others, more]).comparisons[SHOWN]
    if more in FLIPS:
        assert (now.others, dosed(now)) == (before.others, dosed(before))
        assert now.flips == (*before.flips, more.label)
    elif more.label in dosed(now):
        # the second dose beside the control makes an axis, which takes the first one along
        assert now.flips == before.flips
        assert {*before.others} - {*now.others} == dosed(now) - dosed(before) - {more.label}
    else:
        assert (now.flips, dosed(now)) == (before.flips, dosed(before))
        assert now.others == (*before.others, more.label)


def test_what_is_kept_is_one_axis_on_which_a_word_and_no_word_are_its_ends():
    kept = ["flip?p=0.4", "flip?p=0.4&keep=0.5", "flip?p=0.4&others=kept"]
    found = designed([TRUTH, *map(read_condition, kept)])
    (axis,) = found.series
    assert (axis.axis.name, axis.axis.options) == ("flip keep", "p=0.4")
    assert dict(axis.doses) == dict(zip(kept, (0, 0.5, 1), strict=True))
    assert not any(one.axis for one in found.families)  # its ends are compared once


def test_the_first_modality_is_compared_with_the_controls_of_the_others():
    planned = study("flips", agent="random", p=[0, 0.4], condition=["nudge"], modality=[SHOWN, "symbolic?tell=outcome"])
    found = design_of(planned)
    first, second = found.comparisons.values()
    assert (first.others, first.controls) == (("nudge",), ("symbolic?tell=outcome",))
    assert second.control == "symbolic?tell=outcome"
    assert (second.others, second.controls) == (("nudge + symbolic?tell=outcome",), ())
    assert second.flips == ("flip?p=0.4 + symbolic?tell=outcome",)
    assert found.controls == {"truth", "symbolic?tell=outcome"}
    assert found.control("nudge + symbolic?tell=outcome") == "symbolic?tell=outcome"


def test_a_dose_of_the_plant_is_an_axis_whose_first_level_is_the_plant_of_the_study():
    stiffness = [read_condition(f"plant?friction={value}", plant="twin") for value in (0.2, 0.3, 2)]
    found = designed([TRUTH, *HANDS[:2], *stiffness]).comparisons[SHOWN]
    assert {one.axis.name: dict(one.doses) for one in found.axes} == {
        "plant pose_error": {"truth": 0, "plant?pose_error=0.01": 0.01, "plant?pose_error=0.02": 0.02},
        "plant friction below 1": {"truth": 0, "plant?friction=0.3": 0.7, "plant?friction=0.2": 0.8},
    }
    assert (found.control, found.others) == ("truth", ("plant?friction=2",))


FLIP, STICKY, BOTH = "flip?p=0.4", "flip?p=0.4&others=kept", "flip?p=0.4 + nudge"
CROSSED = "flip?p=0,0.4 + tremble?p=0,0.1"


def arms(*specs):
    return arms_of(one for spec in specs for one in (sweep(spec) if "," in spec else (read_condition(spec),)))


@pytest.mark.parametrize(
    ("specs", "found"),
    [
        (("truth", "tremble?p=0.2", "nudge", "tremble?p=0.1"), {"tremble p": {"truth": 0, "tremble?p=0.1": 0.1, "tremble?p=0.2": 0.2}}),
        (("nudge", BOTH, "nudge + flip?p=0.4", "nudge + flip?p=0.2"), {"flip rate|nudge": {"nudge": 0, "nudge + flip?p=0.2": 0.2, BOTH: 0.4}}),
        (("nudge", BOTH, "nudge + flip?p=0.4"), {}),  # equal doses are one level
        (("truth", "drop?p=0.1&luck=flip", "drop?p=0.2&luck=flip", "drop?p=0.1"), {"drop p|luck=flip": {"truth": 0, "drop?p=0.1&luck=flip": 0.1, "drop?p=0.2&luck=flip": 0.2}}),
        (("truth", "tremble?p=0.1", "tremble?p=0.2 + rgb", "tremble?p=0.3 + rgb"), {}),  # modalities are apart
        (("flip?p=0.2&keep=0.5", "flip?p=0.2&keep=0.6", "flip?p=0.2&keep=0.7"), {"flip keep|p=0.2": {f"flip?p=0.2&keep={k}": k for k in (0.5, 0.6, 0.7)}}),
    ],
)  # fmt: skip
def test_conditions_that_differ_in_one_dose_alone_are_a_series_from_0(specs, found):
    made = {
        "|".join(filter(None, (one.axis.name, one.axis.options, one.axis.rest))): one.doses
        for one in series_of(arms(*specs))
    }
    assert made == found
    assert all([*doses.values()] == sorted(doses.values()) for doses in made.values())


@pytest.mark.parametrize(
    ("agents", "name", "doses"),
    [
        ({"small?t=0": "x:/h?t=0", "small?t=2": "x:/h?t=2", "small?t=1": "x:/h?t=1"}, "small", [0, 1, 2]),
        ({"cold": "x:/h?t=0", "warm": "x:/h?t=1", "hot": "x:/h?t=2"}, "cold, warm, hot", [0, 1, 2]),
        (["random", "a:b?t=1&x=2", "a:b?x=2&t=0", "a:b?t=0.5&x=2", "a:b?t=0.5&x=3"], "a:b?x=2", [0, 0.5, 1]),
        (["a?t=1", "a?t=2", "a?t=1e300"], None, None),  # no curve can be fitted to the third
    ],
)
def test_agents_that_differ_in_one_number_are_a_series_under_what_they_share(agents, name, doses):
    found = [*series_of_agents(agents if isinstance(agents, dict) else dict(zip(agents, agents, strict=True)))]
    assert [(one.agent, [*one.doses.values()]) for one in found] == ([(name, doses)] if name else [])
    for one in found:
        assert (cause(one.axis), at_dose(0, one.axis)) == ("higher values of t", "at a t of 0")


@pytest.mark.parametrize(
    ("specs", "weights"),
    [
        (("truth", "nudge", BOTH), []),  # one of the four is missing
        (("truth", "nudge", FLIP, BOTH), [{"truth": 1, "nudge": -1, FLIP: -1, BOTH: 1}]),
        (("truth", "flip?p=0.2,0.4", "tremble?p=0.1,0.2"), []),
        (("truth", "flip?p=0.4 + tremble?p=0.1"), []),  # one dose each
        (("truth", FLIP, f"{FLIP} + tremble?p=0.1", "flip?p=0.2 + tremble?p=0.1"), [{}]),
        (
            (CROSSED,),
            [dict(zip(("truth", "tremble?p=0.1", FLIP, f"{FLIP} + tremble?p=0.1"), (1, -1, -1, 1), strict=True))] * 2,
        ),
    ],
)
def test_what_is_crossed_has_weights_where_every_combination_is_played(specs, weights):
    assert [one.weights for one in crossed_of(arms(*specs))] == weights


def factors_in(*specs, controls=()):
    return {one.axis: one.groups for one in factors_of(arms(*specs), controls)}


@given(st.permutations(["truth", FLIP, STICKY, "nudge", BOTH, f"{STICKY} + nudge", "flip?p=0.2"]))
def test_every_context_is_a_group_of_its_factor_in_any_order_and_what_says_nothing_comes_first(specs):
    (groups,) = factors_in(*specs).values()
    assert {*groups} == {(FLIP, STICKY), (BOTH, f"{STICKY} + nudge")}
