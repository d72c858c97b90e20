"""Derivatives are those of the likelihood; the likelihood is its formula."""

import numpy as np
import pytest
from fitted_trials import flip_trials
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.choices import choices_of, hear, rule

TRIALS = flip_trials("random", seed=4, p=(0.2,), repetitions=1, trials=12)
HEARD = [hear(trial) for trial in TRIALS]
CHOICES = choices_of(TRIALS, HEARD)
SOFTMAX = RIVALS["softmax-memory"].versions(CHOICES, HEARD)["softmax-memory"]
LAPSE = RIVALS["human-inspired"].versions(CHOICES, HEARD)["human-inspired:target-any"]
WAYS = st.tuples(*[st.floats(-3, 3)] * 6, *[st.floats(0.02, 0.98)] * 2).map(np.array)


def terms(model, values):
    """The log-probability of each choice."""
    return np.log(model.probabilities(values)[np.arange(len(CHOICES)), CHOICES.chosen])


def moved(values, place, by):
    there = values.copy()
    there[place] += by
    return there


@settings(max_examples=25, deadline=None)
@given(values=WAYS)
def test_scores_are_the_slope_of_every_term(values):
    scores = SOFTMAX.scores(values)
    for place in range(8):
        up, down = (terms(SOFTMAX, moved(values, place, by)) for by in (1e-5, -1e-5))
        assert scores[:, place] == pytest.approx((up - down) / 2e-5, abs=1e-5)


@settings(max_examples=15, deadline=None)
@given(values=WAYS)
def test_information_is_how_the_pulls_bend_the_likelihood(values):
    information = SOFTMAX.slope(values).information
    for place in range(6):
        up, down = (SOFTMAX.slope(moved(values, place, by)).uphill[:6] for by in (1e-5, -1e-5))
        assert information[place, :6] == pytest.approx((down - up) / 2e-5, abs=1e-3)
    assert np.linalg.eigvalsh(information).min() > -1e-9 * np.trace(information)


@settings(max_examples=25, deadline=None)
@given(values=WAYS)
def test_probabilities_are_probabilities_and_the_slope_is_the_sum_of_all_choices(values):
    assert SOFTMAX.probabilities(values).sum(axis=1) == pytest.approx(1)
    slope = SOFTMAX.slope(values)
    assert slope.log_likelihood == pytest.approx(terms(SOFTMAX, values).sum())
    assert slope.uphill == pytest.approx(SOFTMAX.scores(values).sum(axis=0))


@settings(max_examples=25, deadline=None)
@given(lapse=st.floats(0.01, 1))
def test_a_lapse_is_a_mixture_with_chance(lapse):
    values = np.array([lapse])
    slope, scores = LAPSE.slope(values), LAPSE.scores(values)
    follows = rule(HumanInspired(**PRESETS["target-any"]), HEARD)
    assert LAPSE.probabilities(values) == pytest.approx(lapse / 4 + (1 - lapse) * follows)
    assert slope.log_likelihood == pytest.approx(terms(LAPSE, values).sum())
    up, down = (terms(LAPSE, values + by) for by in (1e-6, -1e-6))
    assert scores[:, 0] == pytest.approx((up - down) / 2e-6, rel=1e-3, abs=1e-3)
    assert slope.uphill == pytest.approx(scores.sum(axis=0))
    assert slope.information == pytest.approx(scores.T @ scores)


@pytest.mark.parametrize("model", [SOFTMAX, LAPSE], ids=["softmax", "lapse"])
def test_some_choices_have_the_terms_that_they_have_among_all(model):
    values = np.array(model.starts[0])
    for rows in (CHOICES.trial < 5, CHOICES.trial == 7, CHOICES.trial < 0):
        some = model.at(rows)
        assert some.probabilities(values) == pytest.approx(model.probabilities(values)[rows])
        assert some.scores(values) == pytest.approx(model.scores(values)[rows])
        assert some.slope(values).log_likelihood == pytest.approx(terms(model, values)[rows].sum())
        assert some.at(np.ones(rows.sum(), dtype=bool)).slope(values).uphill == pytest.approx(some.slope(values).uphill)


def test_the_ends_of_both_shares_are_smooth():
    """At 0 and 1 powers of 0 and their derivatives must be what they are just inside."""
    for edge in (0.0, 1.0):
        inside = SOFTMAX.scores(np.array([0, 0, 1, 0, 0, 0, abs(edge - 1e-7), abs(edge - 1e-7)]))
        there = SOFTMAX.scores(np.array([0, 0, 1, 0, 0, 0, edge, edge]))
        assert there == pytest.approx(inside, abs=1e-4)
