"""Doses, crossings and factors are found in the specs of conditions alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.interventions.conditions import read_condition, sweep
from lockprobe.report.prose import at_dose, cause
from lockprobe.statistics.design import crossed_of, factors_of, series_of, series_of_agents
from lockprobe.studies.study import arms_of

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
