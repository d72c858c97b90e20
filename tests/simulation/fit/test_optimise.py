"""The maximum is the greatest there is, and intervals end where the likelihood says."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarked import benchmark
from fitted_trials import flip_trials
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from lockprobe.simulation.fit import optimise
from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.likelihood import BOUND, Lapse
from lockprobe.simulation.fit.optimise import DesignEffects, design_effects, ends, maximise, maximum, parameters
from lockprobe.simulation.fit.situations import Situations

SMALL = {"p": (0.0, 0.4), "repetitions": 1, "trials": 12}


def known(agent, seed=1, **sizes):
    trials = flip_trials(agent, seed, **sizes)
    heard = [hear(trial) for trial in trials]
    return choices_of(trials, heard), heard


def model_of(name, choices, heard, version=None):
    return RIVALS[name].versions(choices, heard)[version or name]


FORGETFUL = known("cognitive:softmax-memory?target=0.6&closed=0.4&failure=2&decay=0.7&reset=0.5&stay=-1", **SMALL)
SOFTMAX = model_of("softmax-memory", *FORGETFUL)
BEST = maximum(SOFTMAX)


@pytest.mark.parametrize("start", range(4))
def test_a_general_optimiser_finds_nothing_better(start):
    """L-BFGS-B of scipy, from places of its own."""
    rng = np.random.default_rng(start)
    begin = np.concatenate([rng.normal(size=6), rng.random(2)])

    def fall(values):
        slope = SOFTMAX.slope(values)
        return -slope.log_likelihood, -slope.uphill

    found = minimize(fall, begin, jac=True, method="L-BFGS-B", bounds=list(SOFTMAX.bounds.values()))
    assert -found.fun <= BEST.log_likelihood + 1e-4


@settings(max_examples=15, deadline=None)
@given(start=st.tuples(*[st.floats(-3, 3)] * 2).map(np.array))
def test_without_a_memory_every_way_leads_to_the_same_maximum(start):
    model = model_of("win-stay-lose-shift", *FORGETFUL)
    assert maximise(model, start).values == pytest.approx(maximum(model).values, abs=1e-3)


def test_at_the_maximum_no_parameter_can_be_bettered_alone():
    for place, (low, high) in enumerate(SOFTMAX.bounds.values()):
        for by in (-1e-3, 1e-3):
            values = BEST.values.copy()
            values[place] = np.clip(values[place] + by, low, high)
            assert SOFTMAX.slope(values).log_likelihood <= BEST.log_likelihood + 1e-6


def test_what_is_held_stays():
    found = maximise(SOFTMAX, BEST.values, {2: 1.0, 6: 0.5})
    assert (found.values[2], found.values[6]) == (1.0, 0.5)
    assert found.log_likelihood < BEST.log_likelihood


def test_a_nested_model_is_never_more_likely():
    fitted = {
        name: maximum(model_of(name, *FORGETFUL)).log_likelihood for name in RIVALS if "softmax" in RIVALS[name].agent
    }
    fitted["random"] = maximum(model_of("random", *FORGETFUL)).log_likelihood
    for chain in (
        ("random", "no-repeat", "win-stay-lose-shift", "softmax-memory"),
        ("random", "failure-memory", "goal-and-failures", "softmax-memory"),
    ):
        values = [fitted[name] for name in chain]
        assert values == sorted(values)
    assert fitted["random"] == pytest.approx(-len(FORGETFUL[0]) * np.log(4))


@pytest.mark.parametrize("place", range(8))
def test_an_interval_ends_where_the_profile_has_fallen_so_far(place):
    cut = 3.84
    low, high = ends(SOFTMAX, BEST, place, cut)
    assert low is None or low < BEST.values[place]
    assert high is None or high > BEST.values[place]
    for end in (low, high):
        if end is not None:
            fallen = 2 * (BEST.log_likelihood - maximise(SOFTMAX, BEST.values, {place: end}).log_likelihood)
            assert fallen == pytest.approx(cut, rel=0.05)


def test_a_lapse_is_the_one_that_is_likeliest_on_a_fine_grid():
    choices, heard = known("human-inspired?lapse=0.2", **SMALL)
    model = model_of("human-inspired", choices, heard, "human-inspired:target-first")
    grid = np.linspace(0.001, 1, 2000)
    terms = [model.slope(np.array([lapse])).log_likelihood for lapse in grid]
    assert maximum(model).values[0] == pytest.approx(grid[int(np.argmax(terms))], abs=1e-3)


def test_where_nothing_lapses_the_lapse_is_exactly_none_and_its_interval_is_not():
    choices, heard = known("human-inspired", **SMALL)
    model = model_of("human-inspired", choices, heard, "human-inspired:target-first")
    (lapse,) = parameters(model, maximum(model), choices)
    assert (lapse.value, lapse.low, lapse.at_bound) == (0.0, 0.0, True)
    assert 0 < lapse.high < 0.1


def test_an_agent_that_never_does_a_thing_has_a_pull_without_end():
    choices, heard = known("random-no-repeat", **SMALL)
    (recent,) = parameters(model := model_of("no-repeat", choices, heard), maximum(model), choices)
    assert recent.at_bound
    assert recent.value == pytest.approx(-BOUND, abs=0.01)
    assert recent.low is None
    assert -BOUND < recent.high < -3


def test_what_nothing_depends_on_may_be_anything():
    """Where nothing is ever told to move there is nothing to stay with."""
    choices, heard = known("random", p=(0.0,), repetitions=1, trials=12)
    still = replace(choices, recent=choices.recent & ~1)
    model = model_of("win-stay-lose-shift", still, heard)
    recent, stay = parameters(model, maximum(model), still)
    assert (stay.low, stay.high) == (None, None)
    assert recent.low is not None
    assert recent.high is not None


@pytest.mark.parametrize("times", [2, 5])
def test_trials_played_over_again_with_the_same_luck_say_nothing_new(times):
    """The design effects rise by just as much as the information does."""
    choices, heard = known("cognitive:softmax-memory?target=1&recent=-1", trials=6)
    model = model_of("win-stay-lose-shift", choices, heard)
    best = maximum(model)
    luck = design_effects(model, best.values, choices.cluster)
    assert luck.parameters.min() > 1
    once = model.situations
    more = replace(model, situations=Situations(np.tile(once.which, times), times * once.counts))
    repeated = design_effects(more, best.values, np.tile(choices.cluster, times))
    assert repeated.parameters == pytest.approx(times * luck.parameters)
    assert repeated.overall == pytest.approx(times * luck.overall)


def test_independent_choices_share_no_luck():
    """Clusters dealt at random hold nothing in common."""
    choices, heard = known("random", p=(0.0,), trials=40, repetitions=2)
    dealt = np.random.default_rng(1).integers(0, 80, len(choices))
    model = model_of("favourite-labels", choices, heard, "favourite-labels")
    assert design_effects(model, maximum(model).values, dealt).overall < 1.5
    alone = np.zeros(len(choices), dtype=np.int64)
    assert design_effects(model, maximum(model).values, alone).overall == 1


def test_intervals_that_knew_nothing_of_shared_luck_would_hold_the_truth_too_rarely(monkeypatch):
    """Agents that act at random have no favourite labels; 36 intervals of each kind."""
    studies = []
    for seed in range(12):
        choices, heard = known("random", seed, repetitions=1, trials=12)
        model = model_of("favourite-labels", choices, heard)
        studies.append((model, maximum(model), choices))

    def held():
        found = [one for study in studies for one in parameters(*study)]
        return sum(one.low <= 0 <= one.high for one in found) / len(found)

    allowed_for = held()
    monkeypatch.setattr(optimise, "design_effects", lambda model, values, cluster: DesignEffects(0 * values + 1, 1.0))
    assert allowed_for > 0.85
    assert held() < 0.75


def test_one_choice_is_enough_not_to_break():
    """One of two joints, against the rule: likelihood lapse / 2, so that the end solves -2 log(lapse) = 3.84."""
    one = Lapse.of(follows=np.array([[1.0, 0.0]]), chosen=np.array([1]), present=np.ones((1, 2), dtype=bool))
    best = maximum(one)
    assert best.values[0] == 1
    low, high = ends(one, best, 0, 3.84)
    assert low == pytest.approx(np.exp(-1.92), abs=0.01)
    assert high is None


def test_of_a_pull_that_nothing_shows_both_ends_are_far():
    """An agent that never repeats: with its joint attempted last at the bound, nothing says if moving mattered."""
    choices, heard = known(benchmark("known_agents").Favourites(by="place", pull=1.0, repeats=False))
    model = model_of("softmax-memory", choices, heard)
    best = maximum(model)
    recent, stay = (list(model.bounds).index(name) for name in ("recent", "stay"))
    assert best.values[recent] == -BOUND
    low, high = ends(model, best, stay, 4.0)
    assert low is None
    assert high > 5
