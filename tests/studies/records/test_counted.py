"""Conditions without a valid trial, and those in which nothing was changed."""

from builders import make_trial, play_study

from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.counted import counted, idle_conditions, invalid_conditions

STUDY = study(StudyOptions(agent=["random"], trials=2, p=[0, 0.4, 0.6], repetitions=1, max_steps=2))


def test_a_condition_is_named_once_all_that_was_played_of_it_ended_as_an_error():
    trials = [
        make_trial([0], budget=2, broken="reply"),
        make_trial([0, 0], budget=2, trial=2),
        make_trial([0], budget=2, p=0.4, broken="reply"),
        make_trial([0], budget=2, p=0.4, broken="model", trial=2),
    ]  # and nothing of p = 0.6
    (found,) = invalid_conditions(STUDY, counted(trials))
    assert (found.condition, found.errors, found.owed) == ("flips/random/flip?p=0.4", 2, 1)
    assert found.first.boundary == "reply"
    assert invalid_conditions(STUDY, []) == []


def test_a_condition_is_named_if_it_should_act_and_never_did():
    planned = study(
        "flips", agent=["human-inspired", "random"], p=[0, 0.4], condition=["nudge", "history?last=50"], trials=4
    )
    assert idle_conditions(planned, counted(play_study(planned))) == [
        "flips/human-inspired/history?last=50",
        "flips/random/history?last=50",
    ]
    assert idle_conditions(planned, []) == []
