"""The rivals, by name, and the agents that act as fitted."""

import numpy as np
import pytest
from fitted_trials import flip_trials

from lockprobe import run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import UnknownName
from lockprobe.simulation.fit import fit_agents
from lockprobe.simulation.fit.candidate_models import RIVALS, candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear, rule
from lockprobe.simulation.fit.optimise import maximum

TRIALS = flip_trials("human-inspired:target-last?lapse=0.3", p=(0.2,), trials=5)


def test_names_are_theirs_and_random_is_always_among_them():
    assert [rival.name for rival in candidates_named()] == list(RIVALS)
    assert [rival.name for rival in candidates_named(["random-map", "no-repeat"])] == [
        "random",
        "no-repeat",
        "random-map",
    ]
    with pytest.raises(
        UnknownName, match=r"no model is called 'randm-map' \(did you mean 'random-map'\?\).*human-insp"
    ):
        candidates_named(["randm-map"])


def test_the_spec_of_a_fitted_model_is_an_agent_with_its_probabilities():
    """But for the four digits of a spec."""
    heard = [hear(trial, {"chain-4": box()}) for trial in TRIALS]
    choices = choices_of(TRIALS, heard)
    (fit,) = fit_agents(TRIALS, folds=2, boxes={"chain-4": box()}).agents
    found = {rival.model: rival for rival in fit.rivals}
    assert {name for name in found if found[name].spec is None} == {
        "favourite-places",
        "favourite-labels",
        "round-robin",
    }
    for name, rival in found.items():
        if rival.spec is None:
            continue
        model = RIVALS[name].versions(choices, heard)[rival.version]
        expected = model.probabilities(maximum(model).values)
        assert rule(resolve(rival.spec).make(), heard) == pytest.approx(expected, abs=5e-3), rival.spec
        assert run_trial(agent=rival.spec, max_steps=3).steps


def test_a_favourite_place_is_a_share_of_choices():
    """A conditional logit of places alone fits the shares exactly."""
    heard = [hear(trial) for trial in TRIALS]
    choices = choices_of(TRIALS, heard)
    for name, kinds in (
        ("favourite-places", np.tile(np.arange(4), (len(choices), 1))),
        ("favourite-labels", choices.label),
    ):
        model = RIVALS[name].versions(choices, heard)[name]
        chances = model.probabilities(maximum(model).values)
        for kind in range(4):
            observed = (kinds[np.arange(len(choices)), choices.chosen] == kind).mean()
            assert chances[kinds == kind].mean() == pytest.approx(observed, abs=1e-3)
