"""Conditions in which nothing was changed."""

from builders import play_study

from lockprobe.studies.options.idle_conditions import idle_conditions
from lockprobe.studies.options.studyfile import study


def test_a_condition_is_named_if_it_should_act_and_never_did():
    planned = study(
        "flips", agent=["human-inspired", "random"], p=[0, 0.4], condition=["nudge", "history?last=50"], trials=4
    )
    trials = {trial.key: trial for trial in play_study(planned)}
    assert idle_conditions(planned, trials) == [
        "flips/human-inspired/history?last=50",
        "flips/random/history?last=50",
    ]
    assert idle_conditions(planned, {}) == []
