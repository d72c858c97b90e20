"""Conditions in which nothing was changed."""

from builders import play_study

from lockprobe.studies.options.idle_conditions import idle_conditions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.counted import counted


def test_a_condition_is_named_if_it_should_act_and_never_did():
    planned = study(
        "flips", agent=["human-inspired", "random"], p=[0, 0.4], condition=["nudge", "history?last=50"], trials=4
    )
    assert idle_conditions(planned, counted(play_study(planned))) == [
        "flips/human-inspired/history?last=50",
        "flips/random/history?last=50",
    ]
    assert idle_conditions(planned, []) == []
