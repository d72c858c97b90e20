"""Persons that a study needs: the formula is held against a simulation of the same model."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from scipy.special import expit

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.people import FEWEST, People, people_needed, power_of, power_with
from lockprobe.simulation.power.people import _intercept as intercept

STUDIES = 4000


def simulated(model, design, group, studies=STUDIES, seed=1):
    """The share of simulated studies in which the test of the first condition against the control is significant."""
    rng, (control, treated) = np.random.default_rng(seed), model.success
    both = np.hypot(model.person_sd, model.effect_sd)
    low, high = intercept(control, model.person_sd), intercept(treated, both)
    u = rng.normal(0, model.person_sd, (studies, group))
    v = rng.normal(0, model.effect_sd, (studies, group))
    within = design == "within"
    other = u if within else rng.normal(0, model.person_sd, (studies, group))
    boxes = model.boxes if within else model.boxes_in_all
    before = rng.binomial(boxes, expit(low + u)) / boxes
    after = rng.binomial(boxes, expit(high + other + v)) / boxes
    assert (before.mean(), after.mean()) == pytest.approx((control, treated), abs=0.005)
    with np.errstate(invalid="ignore", divide="ignore"):
        if within:
            p = stats.ttest_rel(after, before, axis=1).pvalue
        else:
            p = stats.ttest_ind(after, before, axis=1, equal_var=False).pvalue
    return float(np.mean(np.nan_to_num(p, nan=1.0) < 0.05))


MODELS = [
    People(success=(0.4, 0.6)),
    People(success=(0.5, 0.7), boxes=4, person_sd=1.5, effect_sd=1.0),
    People(success=(0.8, 0.65), boxes=2, person_sd=0.5, effect_sd=0.0),
    People(success=(0.3, 0.45), boxes=3, person_sd=2.0, effect_sd=0.5),
]


@pytest.mark.parametrize("design", ["within", "between"])
@pytest.mark.parametrize("model", MODELS)
def test_power_persons_and_smallest_effects_are_those_of_simulated_studies(model, design):
    error, control, group = 4 * np.sqrt(0.8 * 0.2 / STUDIES) + 0.015, model.success[0], 60
    needed = people_needed(model, design).per_condition
    assert simulated(model, design, needed) == pytest.approx(0.8, abs=error)
    assert power_of(model, design, needed) >= 0.8 > power_of(model, design, needed - 1)
    found = power_with(model, design, group * (2 if design == "between" else 1))
    assert (found.per_condition, found.power) == (group, power_of(model, design, group))
    assert found.below < control < found.above
    for share in (found.below, found.above):
        changed = replace(model, success=(control, share))
        assert power_of(changed, design, group) == pytest.approx(0.8, abs=0.002)
        assert simulated(changed, design, group) == pytest.approx(0.8, abs=error)


def test_too_few_persons_have_no_power_that_is_reported_and_may_detect_no_effect_there_is():
    model = People(success=(0.02, 0.6))
    assert power_with(model, "within", FEWEST - 1) is None
    assert power_with(model, "between", 2 * FEWEST - 1) is None
    assert power_with(model, "between", 2 * FEWEST + 1).per_condition == FEWEST
    assert power_with(model, "within", FEWEST).below is None
    with pytest.raises(BadValue, match="target"):
        power_with(model, "within", 40, target=1.0)


@pytest.mark.parametrize("success", [(0.4, 0.6, 0.5), (0.6, 0.4, 0.5)])
def test_power_is_a_number_that_grows_with_persons(success):
    """Far from the control one of the two tails is so small that scipy has no number for it."""
    model = People(success=success, boxes=2, person_sd=2.25, effect_sd=0.3)
    assert all(less < more < 1 for less, more in pairwise(power_of(model, "within", n) for n in range(100, 400, 25)))
    assert people_needed(model, "within", 0.9).people == 181


def test_without_an_effect_the_test_rejects_as_often_as_it_may():
    model = People(success=(0.5, 0.5))
    assert power_of(model, "within", 200) == pytest.approx(0.05)
    assert simulated(model, "within", 200) == pytest.approx(0.05, abs=0.015)
    assert people_needed(model, "between") is None


def test_several_conditions_are_corrected_and_the_hardest_comparison_decides():
    two, three = People(success=(0.4, 0.6)), People(success=(0.4, 0.6, 0.9))
    assert people_needed(three, "within").people > people_needed(two, "within").people
    between = people_needed(three, "between")
    assert between.people == 3 * between.per_condition


def test_a_huge_effect_needs_no_fewer_than_the_test_can_bear():
    assert people_needed(People(success=(0.05, 0.95)), "within").people == FEWEST


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"success": (0.4,)}, "success"), ({"success": (0.0, 0.5)}, "success"), ({"boxes": 0}, "boxes"),
        ({"person_sd": -1.0}, "person_sd"), ({"effect_sd": 11.0}, "effect_sd"),
    ],
)  # fmt: skip
def test_what_makes_no_model_is_refused(wrong, said):
    with pytest.raises(BadValue, match=said):
        People(**{"success": (0.4, 0.6), **wrong})
