"""The design of a study, from specs alone: every contrast has one family; doses, crossings and factors."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import read_condition, sweep
from lockprobe.statistics.design import CONDITIONS, CONTROLS, FLIPS, crossed_of, factors_of, series_of
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study import Study, arms_of, design_of
from lockprobe.trial.condition import Condition, Contrast

TRUTH = Condition()
FLIPS_ACTING = [read_condition(f"flip?p={p}") for p in (0.2, 0.4, 0.8)]
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


def compared(design, modality=SHOWN):
    """Family -> what is compared with the control, in a modality."""
    return {one.name: one.groups[0][1:] for one in design.against_controls if one.modality == modality}


chosen = st.tuples(
    st.lists(st.sampled_from(FLIPS_ACTING), unique_by=lambda one: one.label),
    st.lists(st.sampled_from(OTHERS), unique_by=lambda one: one.label),
)


@pytest.mark.parametrize(("specs", "control"), [(("nudge", "flip?p=0"), "flip?p=0"), (("nudge", "warn"), "nudge")])
def test_the_control_is_the_truth_or_else_the_first(specs, control):
    assert [*designed(map(read_condition, specs)).controls.values()] == [control]


@given(chosen)
def test_every_condition_but_the_control_is_in_one_family(both):
    flips, others = both
    found = compared(designed([TRUTH, *flips, *others]))
    assert sorted(label for own in found.values() for label in own) == sorted(one.label for one in (*flips, *others))


@given(chosen, st.sampled_from([*FLIPS_ACTING, *OTHERS]))
def test_a_condition_more_changes_no_other_family(both, more):
    flips, others = both
    if more in (*flips, *others) or not flips:  # the first flip that acts says of which kind the axis is
        return
    before, now = (compared(designed([TRUTH, *own])) for own in ((*flips, *others), (*flips, *others, more)))
    (own,) = (name for name, labels in now.items() if more.label in labels)
    for name in before.keys() - {own}:
        # the second dose beside the control makes an axis, which takes the first one along
        taken = {*now[own]} - {more.label} if own not in before else set()
        assert now[name] == tuple(label for label in before[name] if label not in taken)
    assert own not in before or {*now[own]} == {*before[own], more.label}


def test_what_is_kept_is_one_axis_on_which_a_word_and_no_word_are_its_ends():
    kept = ["flip?p=0.4", "flip?p=0.4&keep=0.5", "flip?p=0.4&others=kept"]
    found = designed([TRUTH, *map(read_condition, kept)])
    (axis,) = found.series
    assert (axis.name, axis.options) == ("flip keep", "p=0.4")
    assert dict(axis.doses) == dict(zip(kept, (0, 0.5, 1), strict=True))
    assert {one.name for one in found.families} == {CONDITIONS, CONTROLS}  # its ends are compared once


def test_the_first_modality_is_compared_with_the_controls_of_the_others():
    planned = study("flips", agent="random", p=[0, 0.4], condition=["nudge"], modality=[SHOWN, "symbolic?tell=outcome"])
    found = design_of(planned)
    first, second = (compared(found, modality) for modality in found.shown)
    assert (first[CONDITIONS], first[CONTROLS]) == (("nudge",), ("symbolic?tell=outcome",))
    assert (second[CONDITIONS], second[CONTROLS]) == (("nudge + symbolic?tell=outcome",), ())
    assert second[FLIPS.name] == ("flip?p=0.4 + symbolic?tell=outcome",)
    assert [*found.controls.values()] == ["truth", "symbolic?tell=outcome"]
    assert found.control("nudge + symbolic?tell=outcome") == "symbolic?tell=outcome"


def test_a_dose_of_the_plant_is_an_axis_whose_first_level_is_the_plant_of_the_study():
    stiffness = [read_condition(f"plant?friction={value}", plant="twin") for value in (0.2, 0.3, 2)]
    found = designed([TRUTH, *HANDS[:2], *stiffness])
    assert {one.name: dict(one.doses) for one in found.series} == {
        "plant pose_error": {"truth": 0, "plant?pose_error=0.01": 0.01, "plant?pose_error=0.02": 0.02},
        "plant friction below 1": {"truth": 0, "plant?friction=0.3": 0.7, "plant?friction=0.2": 0.8},
    }
    assert (found.control("truth"), compared(found)[CONDITIONS]) == ("truth", ("plant?friction=2",))


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
    made = {"|".join(filter(None, (one.name, one.options, one.rest))): one.doses for one in series_of(arms(*specs))}
    assert made == found
    assert all([*doses.values()] == sorted(doses.values()) for doses in made.values())


FOUR = Contrast(of=("truth", f"{FLIP} + tremble?p=0.1"), minus=("tremble?p=0.1", FLIP))


@pytest.mark.parametrize(
    ("specs", "found"),
    [
        (("truth", "nudge", BOTH), []),  # one of the four is missing
        (("truth", "nudge", FLIP, BOTH), [Contrast(of=("truth", BOTH), minus=("nudge", FLIP))]),
        (("truth", "flip?p=0.2,0.4", "tremble?p=0.1,0.2"), []),
        (("truth", "flip?p=0.4 + tremble?p=0.1"), []),  # one dose each
        (("truth", FLIP, f"{FLIP} + tremble?p=0.1", "flip?p=0.2 + tremble?p=0.1"), [None]),
        ((CROSSED,), [FOUR, FOUR]),
    ],
)
def test_what_is_crossed_has_an_interaction_where_every_combination_is_played(specs, found):
    made = [one.interaction for one in crossed_of(arms(*specs))]
    assert [one and ({*one.of}, {*one.minus}) for one in made] == [one and ({*one.of}, {*one.minus}) for one in found]


@given(st.permutations(["truth", FLIP, STICKY, "nudge", BOTH, f"{STICKY} + nudge", "flip?p=0.2"]))
def test_every_context_is_a_group_of_its_factor_in_any_order_and_what_says_nothing_comes_first(specs):
    (factor,) = factors_of(arms(*specs), ())
    assert {*factor.groups} == {(FLIP, STICKY), (BOTH, f"{STICKY} + nudge")}
