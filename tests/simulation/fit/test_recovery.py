"""Known parameters and known models are found again, and findings are true. The full figures stand in docs/cognitive-models.md."""

import pytest

from lockprobe.foundation.errors import UnknownName
from lockprobe.report.prose.model_fit import finding
from lockprobe.simulation.fit import fit_agents, optimise
from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.known_agents import WORLDS, Favourites, FirstFour, KnownAgent
from lockprobe.simulation.fit.optimise import DesignEffects, maximum
from lockprobe.simulation.fit.recovery import (
    RecoveryDesign,
    recover_findings,
    recover_models,
    recover_parameters,
    simulate,
)

SMALL = RecoveryDesign(p=(0.0, 0.3, 0.6), repetitions=2, trials=10)
TRUTH = {"target": 1.0, "failure": 2.0, "decay": 0.8, "reset": 0.5, "stay": -1.0}
AGENTS = {
    "random": "random",
    "win-stay-lose-shift": "cognitive:softmax-memory?recent=-1.5&stay=2.5",
    "softmax-memory": "cognitive:softmax-memory?target=1.5&closed=0.5&failure=3&decay=0.9&reset=0.5&recent=1&stay=-1.5&position=1.2",
    "human-inspired": "human-inspired:target-first?lapse=0.15",
    "random-map": "cognitive:random-map?window=1&avoid=last&lapse=0.15",
}


def share(found):
    return sum(one.covered for one in found) / len(found)


def test_the_true_model_wins():
    """At least 4 of 5 small studies; by the full figures 95 % and more win."""
    found = recover_models(AGENTS, sets=1, design=SMALL, seed=11)
    assert [one.model for one in found] == list(AGENTS)
    assert all(sum(one.bic.values()) == sum(one.aicc.values()) == one.sets == 1 for one in found)
    assert sum(one.bic.get(one.model, 0) for one in found) >= 4


def test_parameters_are_found_and_intervals_hold_them():
    """32 intervals: 0.95 less three Monte Carlo errors, were they independent, is 0.83."""
    found = recover_parameters(TRUTH, sets=4, design=SMALL, seed=21)
    assert {one.name: one.truth for one in found} == dict.fromkeys(("closed", "recent", "position"), 0.0) | TRUTH
    assert share(found) >= 0.83
    for one in found:
        assert abs(one.median - one.truth) < 4 * 1.25 * one.spread / 4**0.5


def test_intervals_that_knew_nothing_of_shared_luck_would_hold_them_too_rarely(monkeypatch):
    """Agents that act at random have no favourite labels; 36 intervals of each kind."""
    studies = []
    for seed in range(12):
        trials = simulate("random", RecoveryDesign(repetitions=1, trials=12), seed)
        heard = [hear(trial) for trial in trials]
        choices = choices_of(trials, heard)
        model = RIVALS["favourite-labels"].versions(choices, heard)["favourite-labels"]
        studies.append((model, maximum(model), choices))

    def held():
        found = [one for study in studies for one in optimise.parameters(*study)]
        return sum(one.low <= 0 <= one.high for one in found) / len(found)

    known = held()
    monkeypatch.setattr(optimise, "design_effects", lambda model, values, cluster: DesignEffects(0 * values + 1, 1.0))
    assert known > 0.85
    assert held() < 0.75


@pytest.mark.parametrize(
    "agent",
    [
        Favourites(by="label", pull=1.0),
        Favourites(by="label", pull=1.0, repeats=False),
        Favourites(by="label", pull=1.5, failure=1.0),
        FirstFour(then="stays"),
    ],
    ids=repr,
)
def test_agents_are_not_told_what_failures_do_to_them_by_models_that_lost_or_that_need_no_reports(agent):
    """The first, second and last heed no report; the third leaves what just failed, which looks like the opposite."""
    models = ["favourite-labels", "failure-memory", "softmax-memory", "random-map"]  # winners, and what says it
    (one,) = fit_agents(simulate(agent, SMALL, 1), folds=2, models=models).agents
    assert one.described is not None
    assert "joint that has just failed" not in finding(one)
    assert "still where it was" not in finding(one)


def test_what_findings_claim_is_held_against_the_truth():
    names = ("prefers labels, never repeats", "all joints once, then stays", "failure memory")
    labels, stays, memory = recover_findings({name: WORLDS[name] for name in names}, sets=1, design=SMALL, seed=31)
    assert [one.world for one in (labels, stays, memory)] == list(names)
    assert (labels.best, labels.described, labels.claims) == ({"softmax-memory": 1}, 1, {"recent -": 1})
    assert (stays.best, stays.described, stays.claims) == ({"random-map": 1}, 1, {})
    assert (memory.best, memory.claims) == ({"failure-memory": 1}, {"reports +": 1, "failure -": 1})
    assert [(one.false, one.misled, one.sets) for one in (labels, stays, memory)] == [({}, 0, 1)] * 3


def test_a_claim_against_the_truth_is_counted():
    agent = "cognitive:softmax-memory?failure=2&decay=0.8&reset=0.8"
    worlds = {
        "heeds nothing": KnownAgent(agent=agent, pulls={"failure": None}),
        "returns to what failed": KnownAgent(agent=agent, pulls={"reports": 1, "failure": 1}),
    }
    deaf, back = recover_findings(worlds, sets=1, design=SMALL, seed=31)
    assert (deaf.false, deaf.misled) == ({"reports +": 1}, 1)
    assert (back.false, back.misled) == ({"failure -": 1}, 1)


def test_a_study_is_played_as_any_other():
    trials = simulate(
        "random", RecoveryDesign(p=(0.0, 0.5), repetitions=2, trials=3, flip="outcome-only", budget=7), seed=4
    )
    assert len(trials) == 12
    assert {spec for trial in trials for spec in trial.specs} == {"flip?p=0.5"}
    assert {trial.modality for trial in trials} == {"symbolic?tell=outcome"}
    assert max(len(trial.steps) for trial in trials) == 7
    assert all(step.told_state is None for trial in trials for step in trial.steps)
    assert simulate("random", RecoveryDesign(p=(0.5,), repetitions=1, trials=1), seed=4) != simulate(
        "random", RecoveryDesign(p=(0.5,), repetitions=1, trials=1), seed=5
    )


def test_an_unknown_model_is_named():
    with pytest.raises(UnknownName, match="no model is called 'chess'"):
        recover_models({"chess": "random"}, sets=1)
