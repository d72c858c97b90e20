"""Studies of people: the stated model is what is played, and the test of the report judges it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.people import FEWEST, People, people_power
from lockprobe.simulation.power.simulator import Simulation
from lockprobe.statistics.differences import each_difference

MODELS = [
    People(success=(0.4, 0.6)),
    People(success=(0.5, 0.7, 0.9), boxes=4, person_sd=1.5, effect_sd=1.0),
    People(success=(0.8, 0.65), boxes=2, person_sd=0.5, effect_sd=0.0),
    People(success=(0.02, 0.98), person_sd=3.0),
]
BOTH = [replace(one, design=design) for one in MODELS for design in ("within", "between")]


@pytest.mark.parametrize("model", BOTH)
def test_persons_open_the_stated_share_of_boxes_and_meet_no_luck_twice(model):
    """The spread of what a person opens is that of their skill and of the luck of their boxes."""
    conditions = len(model.success)
    groups = model._played(6000 * conditions, np.random.default_rng(1))
    everybody = np.concatenate([one.player for one in groups])
    assert np.unique(everybody, return_counts=True)[1].tolist() == [model.boxes_in_all] * 6000 * conditions
    pairs = np.stack([everybody, np.concatenate([one.trial for one in groups]).astype(str)])
    assert len(np.unique(pairs, axis=1).T) == len(everybody)
    assert all(len(np.unique(one.trial)) == len(one) for one in groups)  # nobody else has it under this condition
    for place, (one, share) in enumerate(zip(groups, model.success, strict=True)):
        own = np.bincount(np.unique(one.player, return_inverse=True)[1], one.solved) / (len(one) / len({*one.player}))
        assert own.mean() == pytest.approx(share, abs=0.02)
        skill = np.random.default_rng(2).normal(0, np.hypot(model.person_sd, model.effect_sd * bool(place)), 200_000)
        logit = np.linspace(-20, 20, 4001)
        means = np.array([expit(a + skill[:2000]).mean() for a in logit[::20]])
        chance = expit(np.interp(share, means, logit[::20]) + skill)
        boxes = model.boxes if model.design == "within" else model.boxes_in_all
        assert own.var() == pytest.approx(chance.var() + (chance * (1 - chance)).mean() / boxes, abs=0.01)


def power(model, *persons, studies=60):
    (found,) = people_power([model], Simulation(trials=persons, studies=studies, least=1))
    return [rate.power for rate in found.measured]


@pytest.mark.parametrize("design", ["within", "between"])
def test_what_is_detected_is_what_the_report_says_and_nothing_where_nothing_changes(design):
    model = People(success=(0.4, 0.6), design=design)
    luck, tests = (lambda: np.random.default_rng(3)), (lambda: np.random.default_rng(4))
    said = [place for place, one in each_difference(model._played(120, luck()), tests()) if one.p_value < 0.05]
    assert list(model.detected(120, luck(), tests())) == said
    few, many = power(model, 40, 200)
    assert few < 0.6
    assert many > 0.8
    assert power(replace(model, success=(0.5, 0.5), boxes=2), 40)[0] <= 0.1


def test_the_hardest_comparison_decides_and_conditions_are_corrected():
    two, three = People(success=(0.4, 0.65)), People(success=(0.4, 0.65, 0.95))
    assert power(three, 60)[0] < power(two, 60)[0]
    assert power(replace(three, success=(0.4, 0.95, 0.95)), 60)[0] > 0.95


def test_too_few_persons_and_what_makes_no_model_are_refused():
    between = People(success=(0.4, 0.6), design="between")
    with pytest.raises(BadValue, match="20 or more in all, 10 under each condition"):
        power(between, 2 * FEWEST - 1)
    with pytest.raises(BadValue, match="10 or more"):
        power(replace(between, design="within"), FEWEST - 1)
    for wrong in ({"success": (0.4,)}, {"success": (0.0, 0.5)}, {"boxes": 0}, {"person_sd": -1.0}, {"effect_sd": 11.0}):
        with pytest.raises(BadValue, match=next(iter(wrong))):
            People(**{"success": (0.4, 0.6), **wrong})
