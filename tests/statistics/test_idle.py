"""A condition that changed nothing is no null result: it is in no comparison, and is named."""

from dataclasses import replace

import pytest
from builders import numbers_of

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import interventions_in
from lockprobe.statistics.idle import Idle, idle_interventions, steps_changed, unheeded
from lockprobe.statistics.summary import summarise
from lockprobe.studies.options.studyfile import study
from lockprobe.testing import play_trials

CHAIN = box("chain-4")


def played(*conditions, agents=("human-inspired",), trials=12, **options):
    """A study of these conditions and its trials."""
    planned = study("flips", agent=list(agents), condition=list(conditions), p=[0], trials=trials, **options)
    named = [
        replace(trial, condition=condition.label)
        for agent in agents
        for condition in planned.conditions
        for trial in play_trials(
            agent, trials, condition=list(interventions_in(condition)), modality=condition.modality
        )
    ]
    return planned, named


def summary(*conditions, agents=("human-inspired",), **options):
    planned, trials = played(*conditions, agents=agents, **options)
    return numbers_of(trials, planned)


@pytest.mark.parametrize("acts", ["history?last=50", "flip?p=1&at=20", "nudge?after=6", "hypothesis"])
def test_a_condition_that_changed_nothing_is_compared_with_nothing(acts):
    found = summary(acts, "flip?p=0.4")
    assert [(one.condition, one.intervention) for one in found.idle] == [(acts, "")]
    assert found.conditions["human-inspired", acts].never_acted
    (effects,) = (*found.effects, *found.on_axes)
    assert [one.condition for one in effects.effects] == ["flip?p=0.4"]


def test_an_intervention_that_changed_nothing_beside_others_is_in_no_interaction():
    crossed = summary("flip?p=0.4", "history?last=50", "flip?p=0.4 + history?last=50")
    assert (
        Idle(
            agent="human-inspired",
            condition="flip?p=0.4 + history?last=50",
            intervention="history?last=50",
            steps=crossed.conditions["human-inspired", "flip?p=0.4 + history?last=50"].steps,
        )
        in crossed.idle
    )
    (effects,) = crossed.effects
    assert [one.condition for one in effects.effects] == ["flip?p=0.4 + history?last=50"]
    assert [one.condition for own in crossed.on_axes for one in own.effects] == ["flip?p=0.4"]


def test_a_dose_that_never_acted_is_in_no_test_of_its_series():
    found = summary("tremble?p=0.0001", "tremble?p=0.2", "tremble?p=0.4")
    ((series, over),) = found.series
    assert series.axis.name == "tremble p"
    (agent,) = over.agents
    assert [one.dose for one in agent.inference.difference.at] == [0.2, 0.4]
    (doses,) = found.on_axes
    assert (doses.axis, [one.condition for one in doses.effects]) == ("tremble p", ["tremble?p=0.2", "tremble?p=0.4"])
    assert found.effects == ()
    assert [one.condition for one in found.idle] == ["tremble?p=0.0001"]


def test_it_is_idle_for_the_agent_for_which_nothing_was_changed():
    found = summary("nudge", agents=("human-inspired", "random"))
    assert [(one.agent, one.condition) for one in found.idle] == [("human-inspired", "nudge")]
    assert [one.agent for one in found.effects] == ["random"]


def test_a_flip_rate_at_which_no_report_was_false_is_compared_with_nothing():
    trials = [trial for p in (0.0, 0.0001, 0.4) for trial in play_trials("human-inspired", 12, p=p)]
    (agent,) = summarise(trials, CHAIN).agents
    assert [one.dose for one in agent.idle] == [0.0001]
    assert [one.dose for one in agent.inference.difference.at] == [0.4]
    (alone,) = summarise([trial for trial in trials if trial.p < 0.4], CHAIN).agents
    assert alone.contrast is None


def test_records_that_do_not_say_are_taken_as_they_are():
    trials = [
        replace(trial, changed={}, changed_steps=0) for trial in play_trials("random", 3, condition="nudge?after=9")
    ]
    assert not steps_changed(trials).known
    assert steps_changed([*trials, *play_trials("random", 1, condition="nudge?after=9")]) is None
    assert steps_changed([]) is None
    assert idle_interventions("random", "nudge?after=9", steps_changed(trials), ["nudge?after=9"]) == []


def test_an_agent_that_chose_as_under_the_control_is_named_and_people_are_not():
    truth, warned = (play_trials("random", 4, condition=acts) for acts in ("truth", "warn"))
    assert unheeded(warned, truth).changed == sum(len(trial.steps) for trial in warned)
    assert (
        unheeded(play_trials("human-inspired", 4, condition="tremble?p=0.5"), play_trials("human-inspired", 4)) is None
    )
    assert unheeded([replace(trial, steps=trial.steps[:1], changed_steps=1) for trial in warned], truth) is None
    people = [replace(trial, agent="participant:1") for trial in truth]
    assert unheeded(warned, people) is None
