"""Which conditions form a series over a dose and which are crossed follows from their specs alone."""

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition
from lockprobe.report.prose.doses import at_dose, cause
from lockprobe.statistics.conditions.axis import Axis
from lockprobe.statistics.conditions.series import SeriesArm, control_of, crossings, series_of, series_of_agents


def arms(*specs):
    conditions = [read_condition(spec) for spec in specs]
    return [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names, modality=one.modality)
        for one in conditions
    ]


def test_doses_of_one_intervention_are_a_series_with_the_truth_at_0():
    (series,) = series_of(arms("truth", "tremble?p=0.2", "nudge", "tremble?p=0.1"))
    assert series.axis == Axis(kind="tremble", dose="p")
    assert list(series.doses.items()) == [("truth", 0.0), ("tremble?p=0.1", 0.1), ("tremble?p=0.2", 0.2)]


def test_an_intervention_with_two_doses_makes_a_series_over_each():
    first = [f"flip?p={p}&keep=0.5" for p in (0.1, 0.2)]
    found = series_of(arms("truth", *first, "flip?p=0.2&keep=0.6", "flip?p=0.2&keep=0.7"))
    assert [(one.axis.name, one.axis.options, [*one.doses.values()]) for one in found] == [
        ("flip rate", "keep=0.5", [0, 0.1, 0.2]),
        ("flip keep", "p=0.2", [0.5, 0.6, 0.7]),
    ]


def test_equal_doses_are_one_level():
    found = series_of(arms("nudge", "nudge + flip?p=0.2", "flip?p=0.2 + nudge", "nudge + flip?p=0.4"))
    assert [[*one.doses] for one in found] == [["nudge", "nudge + flip?p=0.2", "nudge + flip?p=0.4"]]
    assert series_of(arms("nudge", "nudge + flip?p=0.2", "flip?p=0.2 + nudge")) == ()


def test_other_options_and_other_interventions_make_another_series():
    found = series_of(
        arms(
            "truth",
            "nudge",
            "drop?p=0.1&luck=flip",
            "drop?p=0.2&luck=flip",
            "drop?p=0.1",
            "nudge + flip?p=0.2",
            "nudge + flip?p=0.4",
        )
    )
    assert [(one.axis.name, one.axis.rest, len(one.doses)) for one in found] == [
        ("drop p", "", 3), ("flip rate", "nudge", 3),
    ]  # fmt: skip
    assert found[1].doses["nudge"] == 0


def test_modalities_are_apart():
    found = series_of(arms("truth", "tremble?p=0.1", "tremble?p=0.2 + rgb", "tremble?p=0.3 + rgb"))
    assert found == ()


def test_a_crossing_needs_all_four():
    assert crossings(arms("truth", "nudge", "nudge + flip?p=0.4")) == ()
    (found,) = crossings(arms("truth", "nudge", "flip?p=0.4", "nudge + flip?p=0.4"))
    assert (found.neither, found.first, found.second) == ("truth", "nudge", "flip?p=0.4")
    assert found.both == "nudge + flip?p=0.4"


def test_the_control_is_the_truth_or_else_the_first():
    assert control_of(arms("nudge", "flip?p=0")).label == "flip?p=0"
    assert control_of(arms("nudge", "warn")).label == "nudge"
    assert control_of(arms("nudge"), "rgb") is None


def as_they_are(*agents):
    """Agents without names."""
    return dict(zip(agents, agents, strict=True))


def test_agents_with_names_are_a_series_under_their_names():
    swept = {"small?t=0": "x:/home?t=0", "small?t=1": "x:/home?t=1", "small?t=2": "x:/home?t=2"}
    (found,) = series_of_agents(swept)
    assert (found.agent, found.doses) == ("small", {"small?t=0": 0, "small?t=1": 1, "small?t=2": 2})
    (found,) = series_of_agents(dict(zip(("cold", "warm", "hot"), swept.values(), strict=True)))
    assert (found.agent, found.doses) == ("cold, warm, hot", {"cold": 0, "warm": 1, "hot": 2})


def test_agents_that_differ_in_one_number_are_a_series_too():
    (found,) = series_of_agents(as_they_are("random", "a:b?t=1&x=2", "a:b?x=2&t=0", "a:b?t=0.5&x=2", "a:b?t=0.5&x=3"))
    assert (found.agent, found.axis.name) == ("a:b?x=2", "t")
    assert list(found.doses.values()) == [0, 0.5, 1]
    assert series_of_agents(as_they_are("a?t=1", "a?t=2")) == ()
    assert series_of_agents(as_they_are("a?t=1", "a?t=2", "a?t=1e300")) == ()
    assert (cause(found.axis), at_dose(0, found.axis)) == ("higher values of t", "at a t of 0")
