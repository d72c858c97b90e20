"""Which conditions act on a client that keeps its conversation itself."""

import pytest

from lockprobe.errors import BadValue
from lockprobe.interventions.catalogue import place_of, shipped
from lockprobe.mcp_server.playable import SAID, check_playable
from lockprobe.studies.studyfile import study


@pytest.mark.parametrize(
    "condition", ["flip?p=0.4", "tremble?p=0.1", "drop?p=0.2", "nudge", "remark", "warn?rate=0.4", "flip?p=0.4 + nudge"]
)
def test_what_is_told_done_or_said_can_be_played(condition):
    check_playable(study("flips", agent=["random"], condition=[condition]))


@pytest.mark.parametrize(
    "condition", ["history?last=2", "forget?p=0.5", "confidence", "hypothesis", "nudge + forget?p=1"]
)
def test_what_is_remembered_or_asked_for_cannot(condition):
    with pytest.raises(BadValue, match="a client keeps its conversation itself"):
        check_playable(study("flips", agent=["random"], condition=[condition]))


def test_a_condition_that_follows_a_trial_of_another_cannot():
    conditions = ["flip?p=0.4&while=looping", "yoked?p=0.4&how=looping"]
    with pytest.raises(BadValue, match="yoked.*without yoked"):
        check_playable(study("flips", agent=["random"], condition=conditions))


def test_the_study_of_controls_can_be_played():
    check_playable(study("why", agent=["random"]))


def test_those_that_change_words_alone_exist_and_are_asked():
    assert {place_of(shipped()[name]) for name in SAID} == {"asked"}
