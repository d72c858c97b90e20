"""Whether the best model needs what was reported."""

import pytest
from benchmarked import benchmark
from fitted_trials import flip_trials

from lockprobe.simulation.fit.candidate_models import candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.model_comparison import compare_models, lead_by_reports
from lockprobe.simulation.fit.result import CLOSE

KNOWN = benchmark("known_agents")


def winner(agent, *names):
    """The best of some models for an agent, and how far reports put it ahead."""
    trials = flip_trials(agent, p=(0.0, 0.3, 0.6), repetitions=2)
    heard = [hear(trial) for trial in trials]
    best = compare_models(choices_of(trials, heard), heard, candidates_named(names or None)).best
    return best, lead_by_reports(best, trials, heard)


@pytest.mark.parametrize(
    ("agent", "model"),
    [
        ("cognitive:softmax-memory?failure=2&decay=0.8&reset=0.8", "failure-memory"),
        ("cognitive:softmax-memory?recent=-1.5&stay=2.5", "win-stay-lose-shift"),
        ("human-inspired:target-first?lapse=0.15", "human-inspired"),
        ("cognitive:random-map?window=1&avoid=last&lapse=0.15", "random-map"),
    ],
)
def test_agents_that_heed_reports_cannot_do_without_them(agent, model):
    best, lead = winner(agent)
    assert best.rival.name == model
    assert lead > CLOSE


@pytest.mark.parametrize(
    ("agent", "model"),
    [
        (KNOWN.Favourites(by="label", pull=1.0, repeats=False), "softmax-memory"),
        (KNOWN.Favourites(by="place", pull=1.0, repeats=False), "softmax-memory"),
        (KNOWN.FirstFour(then="stays"), "random-map"),
    ],
)
def test_agents_that_ignore_reports_are_predicted_as_well_without(agent, model):
    best, lead = winner(agent, model)
    assert best.rival.name == model
    assert lead < CLOSE


def test_of_a_model_that_heeds_no_report_there_is_nothing_to_say():
    best, lead = winner(KNOWN.Favourites(by="label", pull=1.0))
    assert (best.rival.name, lead) == ("favourite-labels", None)


def test_without_false_reports_and_without_movement_reports_say_nothing_that_attempts_do_not():
    """Nothing is told to have moved within the first step: the model and its twin hear the same, but for their price."""
    trials = flip_trials("random", p=(0.0,), repetitions=2, budget=1)
    heard = [hear(trial) for trial in trials]
    found = compare_models(choices_of(trials, heard), heard, candidates_named(["failure-memory"])).competitors
    memory = next(one for one in found if one.rival.name == "failure-memory")
    assert lead_by_reports(memory, trials, heard) == pytest.approx(-memory.bic + contest_of_nothing(memory))


def contest_of_nothing(memory):
    """BIC with no parameter charged, since none changes any probability."""
    return -2 * memory.best.log_likelihood / memory.repeats
