"""The numbers of a study of conditions: each cell, each change from the control, each dose, and no pooling."""

from dataclasses import replace

import pytest
from builders import numbers_of, play_study

from lockprobe.studies.options.studyfile import study

PLAYED = study(
    "flips",
    agent=["cognitive:perseverant", "random"],
    p=[0, 0.3],
    sweep="tremble?p=0.1,0.2",
    condition=["nudge"],
    trials=6,
    repetitions=2,
    strategy_trials=6,
)


@pytest.fixture(scope="module")
def trials():
    return play_study(PLAYED)


def numbers(trials, agents=PLAYED.agents):
    return numbers_of(trials, replace(PLAYED, agents=agents))


def solved(trials, agent, label):
    return [trial.solved for trial in trials if (trial.agent, trial.condition) == (agent, label)]


def test_every_agent_has_numbers_under_every_condition(trials):
    found = numbers(trials)
    labels = [one.label for one in PLAYED.conditions]
    assert list(found.conditions) == [(agent, label) for agent in PLAYED.agents for label in labels]
    for (agent, label), summary in found.conditions.items():
        own = solved(trials, agent, label)
        assert (summary.success.n, summary.success.count) == (len(own), sum(own)) == (12, sum(own))


def test_effects_are_changes_from_the_control(trials):
    found = numbers(trials)
    families = {(one.agent, one.axis): [effect.condition for effect in one.effects] for one in found.on_axes}
    assert families == {  # a random agent hears no report
        ("cognitive:perseverant", "flip rate"): ["flip?p=0.3"],
        ("cognitive:perseverant", "tremble p"): ["tremble?p=0.1", "tremble?p=0.2"],
        ("random", "tremble p"): ["tremble?p=0.1", "tremble?p=0.2"],
    }
    assert [[effect.condition for effect in one.effects] for one in found.effects] == [["nudge"], ["nudge"]]
    for one in (*found.on_axes, *found.effects):
        assert one.control == "truth"
        for effect in one.effects:
            change = sum(solved(trials, one.agent, effect.condition)) - sum(solved(trials, one.agent, "truth"))
            assert effect.difference.value == pytest.approx(change / 12)


def test_a_series_takes_its_zero_from_the_control_and_pools_no_other_condition(trials):
    (both,) = numbers(trials).series
    series, summary = both
    assert series.doses == {"truth": 0.0, "tremble?p=0.1": 0.1, "tremble?p=0.2": 0.2}
    assert {condition.success.n for agent in summary.agents for condition in agent.conditions} == {12}


def test_an_agent_without_trials_has_no_numbers(trials):
    found = numbers([trial for trial in trials if trial.agent == "random"])
    assert {agent for agent, _ in found.conditions} == {one.agent for one in found.effects} == {"random"}


def test_effects_of_several_agents_are_one_family_and_baselines_another():
    agents = ("cognitive:careful", "cognitive:insistent", "human-inspired")
    planned = study("flips", agent=list(agents), condition=["flip?p=0.5", "tremble?p=0.3"], trials=4, repetitions=1)
    found = numbers_of(play_study(planned), planned)
    assert {one.agent: one.agents for one in found.on_axes} == dict(zip(agents, (2, 2, 1), strict=True))
    assert {one.agent: one.agents for one in found.effects} == dict(zip(agents, (2, 2, 1), strict=True))
