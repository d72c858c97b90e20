"""All models for the trials of some agents."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarked import benchmark
from builders import make_trial, played_by_people, small_study
from fitted_trials import flip_trials

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.report.prose.model_fit import finding
from lockprobe.simulation.fit import RIVALS, fit_agents, fitting
from lockprobe.simulation.fit.candidate_models import candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.model_comparison import compare_models

KNOWN = benchmark("known_agents")
FEW = {"p": (0.0, 0.5), "repetitions": 1, "trials": 4}
QUICK = ["no-repeat", "human-inspired"]


def fitted(trials, **settings):
    return fit_agents(trials, **({"folds": 2} | settings)).agents


RANDOM, HUMAN = flip_trials("random", **FEW), flip_trials("human-inspired", **FEW)


def test_every_agent_has_every_model_the_best_first():
    found = fitted([*HUMAN, *RANDOM])
    assert [one.agent for one in found] == ["human-inspired", "random"]
    for one in found:
        assert {rival.model for rival in one.rivals} == set(RIVALS)
        assert one.rivals[0].behind == 0
        assert [rival.behind for rival in one.rivals] == sorted(rival.bic - one.rivals[0].bic for rival in one.rivals)
        assert (one.trials, one.clusters, one.conditions) == (8, 4, ("truth", "flip?p=0.5"))
        assert one.chance_bits == 2
        assert one.choices == sum(len(trial.steps) for trial in (HUMAN if one.agent == "human-inspired" else RANDOM))
    assert found[0].rivals[0].version == "human-inspired:target-first"


def test_the_criteria_are_their_formulas():
    (one,) = fitted(HUMAN)
    for rival in one.rivals:
        k, n = rival.charged, one.choices / one.repeats
        assert k >= len(rival.parameters)
        deviance = -2 * rival.log_likelihood / one.repeats
        assert rival.bic == pytest.approx(deviance + k * np.log(n) + 2 * np.log(rival.versions))
        assert rival.aicc == pytest.approx(deviance + 2 * k + 2 * k * (k + 1) / (n - k - 1))
    random = next(rival for rival in one.rivals if rival.model == "random")
    assert random.log_likelihood == pytest.approx(-one.choices * np.log(4))
    assert random.held_out.gain == pytest.approx(0)
    assert next(rival.charged for rival in one.rivals if rival.model == "softmax-memory") == 8


def test_luck_that_repeats_itself_is_not_taken_for_evidence():
    """A random agent plays the same trial at every p: seven times the trials, and no more is known."""
    wrong = {"as one": 0, "seven times": 0, "seven times, counted": 0}
    for seed in range(5):
        trials = flip_trials("random", seed, repetitions=1, trials=12)
        for name, used in (("as one", [t for t in trials if t.p == 0]), ("seven times", trials)):
            heard = [hear(trial) for trial in used]
            held = compare_models(choices_of(used, heard), heard, candidates_named(["favourite-labels", "no-repeat"]))
            wrong[name] += held.best.rival.name != "random"
            if used is trials:
                counted = [
                    replace(one, repeats=1.0, effective=one.effective * held.repeats) for one in held.competitors
                ]
                wrong["seven times, counted"] += min(counted, key=lambda one: one.bic).rival.name != "random"
                assert 3 < held.repeats < 9
    assert wrong["as one"] <= wrong["seven times"] <= 1
    assert wrong["seven times, counted"] >= 3


def test_the_same_again_is_the_same_in_any_order():
    assert fitted(HUMAN, models=["softmax-memory"]) == fitted(HUMAN, models=["softmax-memory"])
    found, turned = (fitted(trials, models=QUICK)[0] for trials in (RANDOM, RANDOM[::-1]))
    assert [rival.version for rival in found.rivals] == [rival.version for rival in turned.rivals]
    for one, other in zip(found.rivals, turned.rivals, strict=True):
        assert one.bic == pytest.approx(other.bic)
        assert one.held_out.gain == pytest.approx(other.held_out.gain, abs=1e-6)


def test_errors_are_left_out_and_counted():
    broken = make_trial([0, 1], agent="random", repetition=9, broken="reply")
    empty = replace(make_trial([], agent="random", repetition=10), budget=0)
    (one,) = fitted([*RANDOM, broken, empty], models=QUICK)
    (without,) = fitted(RANDOM, models=QUICK)
    assert (one.left_out, without.left_out) == (2, 0)
    assert replace(one, left_out=0) == without
    with pytest.raises(BadValue, match=r"trials of random: got '1 that ended as an error'"):
        fitted([broken])


@pytest.mark.parametrize("spec", ["round-robin", "human-inspired", "random-no-repeat", "cognitive:random-map"])
def test_agents_that_leave_nothing_to_chance_do_not_break_it(spec):
    """Their pulls are without end; a warning would be an error here."""
    (one,) = fitted(flip_trials(spec, 2, **FEW))
    assert all(np.isfinite(rival.bic) for rival in one.rivals)
    assert any(parameter.at_bound for rival in one.rivals for parameter in rival.parameters)


@pytest.mark.parametrize("joints", [[3], [0] * 20, [3, 2, 1, 0]])
def test_a_single_trial_is_fitted_and_predicts_no_other(joints):
    (one,) = fitted([make_trial(joints)])
    assert (one.trials, one.clusters, one.repeats) == (1, 1, 1)
    assert all(rival.held_out is None for rival in one.rivals)
    assert "No gain over chance in predicting" in finding(one)


def test_each_condition_on_its_own_is_the_fit_of_its_trials():
    apart = fitted(RANDOM, by_condition=True, models=QUICK)
    assert [one.conditions for one in apart] == [("truth",), ("flip?p=0.5",)]
    assert apart[1:] == fitted(RANDOM, conditions=["flip?p=0.5"], models=QUICK)


def test_conditions_that_no_model_predicts_are_in_no_fit_and_named():
    trials = [
        run_trial(agent="random", condition=condition, trial=i)
        for condition in ("truth", "tremble?p=0.2", "forget?p=0.5")
        for i in (1, 2, 3, 4)
    ]
    found = fit_agents(trials, folds=2, models=QUICK)
    assert [one.conditions for one in found.agents] == [("truth", "tremble?p=0.2")]
    assert list(found.unpredicted) == ["forget?p=0.5"]
    assert "forget takes reports" in found.unpredicted["forget?p=0.5"]
    assert found.agents == fit_agents(trials[:8], folds=2, models=QUICK).agents
    with pytest.raises(BadValue, match=r"trials: got 'forget\?p=0.5: forget takes reports from the agent"):
        fit_agents(trials, folds=2, conditions=["forget?p=0.5"])


def test_boxes_of_any_size_and_reports_without_positions():
    trials = [
        *flip_trials("random", lockbox="random-3-1", p=(0.2,), repetitions=1, trials=4, flip="outcome-only"),
        *flip_trials("random", lockbox="random-6-2", p=(0.2,), repetitions=2, trials=4)[4:],
    ]
    (one,) = fitted(trials)
    assert np.log2(3) < one.chance_bits < np.log2(6)
    assert len(next(rival for rival in one.rivals if rival.model == "favourite-places").parameters) == 5


@pytest.mark.parametrize(
    "agent",
    [
        KNOWN.Favourites(by="label", pull=1.0),
        KNOWN.Favourites(by="label", pull=1.0, repeats=False),
        KNOWN.Favourites(by="label", pull=1.5, failure=1.0),
        KNOWN.FirstFour(then="stays"),
    ],
    ids=repr,
)
def test_agents_are_not_told_what_failures_do_to_them_by_models_that_lost_or_that_need_no_reports(agent):
    """The first, second and last heed no report; the third leaves what just failed, which looks like the opposite."""
    models = ["favourite-labels", "failure-memory", "softmax-memory", "random-map"]  # winners, and what says it
    (one,) = fitted(flip_trials(agent, p=(0.0, 0.3, 0.6), repetitions=2), models=models)
    assert one.described is not None
    assert "joint that has just failed" not in finding(one)
    assert "still where it was" not in finding(one)


def test_more_trials_than_needed_are_drawn_by_whole_clusters(monkeypatch):
    monkeypatch.setattr(fitting, "ENOUGH_CHOICES", 60)
    (one,) = fitted(RANDOM, models=QUICK)
    assert one.trials == 2 * one.clusters < 8
    assert one.trials + one.passed_over == 8
    assert one.choices <= 60
    assert one == fitted(RANDOM, models=QUICK)[0]
    monkeypatch.setattr(fitting, "ENOUGH_CHOICES", 1)
    assert fitted(RANDOM, models=QUICK)[0].clusters == 1


def test_probabilities_that_an_agent_recorded_are_the_most_that_can_be_predicted():
    trials = flip_trials("cognitive:softmax-memory?position=2&target=1", 3, p=(0.0,), repetitions=2)
    (one,) = fitted(trials, models=["softmax-memory"])
    assert one.own.gain > one.rivals[0].held_out.gain > 0.1
    assert "the expected maximum for any model" in finding(one)
    assert fitted(RANDOM, models=QUICK)[0].own is None


def test_what_is_being_fitted_is_told():
    said = []
    fitted(RANDOM, models=QUICK, tell=said.append)
    assert "random: human-inspired" in said


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"agents": ["rndom"]}, UnknownName, "no agent in these trials is called 'rndom'"),
        ({"models": ["softmax"]}, UnknownName, "no model is called 'softmax'"),
        (
            {"conditions": ["nudge"]},
            UnknownName,
            "no condition of these trials is called 'nudge'; there are: truth, flip",
        ),
        ({"folds": 1}, BadValue, "folds: got 1"),
    ],
)
def test_mistakes_say_what_there_is(settings, error, message):
    with pytest.raises(error, match=message):
        fitted(RANDOM, **settings)


def test_no_trials_are_a_mistake_too():
    with pytest.raises(BadValue, match="at least one of an agent"):
        fitted([])


def test_people_are_fitted_as_one_agent_and_left_out_whole():
    study = small_study(("participant",), (0.0, 0.4), 2, 4)
    (one,) = fit_agents(played_by_people(study, 2), models=["random", "human-inspired"], folds=4).agents
    assert (one.agent, one.trials, one.clusters) == ("participant", 16, 8)
    assert one.rivals[0].model == "human-inspired"
