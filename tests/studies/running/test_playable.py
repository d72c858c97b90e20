"""Which conditions act on people at the page, and on clients that keep their conversation themselves."""

from dataclasses import dataclass

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import read_condition
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.playable import CLIENT, PERSON, check_playable
from lockprobe.trial.condition import Condition

EVERYBODY = [
    "flip?p=0.4", "flip?p=0.4&only=moved", "tremble?p=0.1", "force?at=4", "drop?p=0.2", "delay?lag=2",
    "correction?p=0.4", "yoked?p=0.4", "yoked?p=0.4&how=shuffle", "nudge", "remark", "distract?p=0.3",
    "warn?rate=0.4", "flip?p=0.4 + nudge",
]  # fmt: skip
NOBODY = ["history?last=2", "hypothesis", "nudge + history?last=0"]


def check(condition, by):
    check_playable([read_condition(condition)], by)


@pytest.mark.parametrize("by", [PERSON, CLIENT], ids=["person", "client"])
def test_what_is_told_done_or_said_can_be_played(by):
    for condition in EVERYBODY:
        check(condition, by)
    check_playable(study("why", agent=["random"]).conditions, by)


@pytest.mark.parametrize(("by", "why"), [(PERSON, "a person remembers what they saw"), (CLIENT, "a client keeps")])
@pytest.mark.parametrize("condition", NOBODY)
def test_what_is_remembered_or_asked_for_cannot(condition, by, why):
    named = condition.removeprefix("nudge + ").partition("?")[0]
    with pytest.raises(BadValue, match=f"condition: got '{named}.*expected what is told or done, or nudge.*{why}"):
        check(condition, by)


def test_another_instruction_reaches_clients_and_not_people(tmp_path):
    (tmp_path / "curt.txt").write_text("{joints} {target} {reply}")
    condition = f"prompt?file={tmp_path / 'curt.txt'}"
    check(condition, CLIENT)
    with pytest.raises(BadValue, match="condition: got 'prompt.*expected what is told or done, or nudge"):
        check(condition, PERSON)


@dataclass(frozen=True, kw_only=True)
class Aloud:
    """Somebody's own intervention on words."""

    after_words = True

    def perceive(self, percept, past, task, rng):
        return percept


def test_words_beside_pictures_do_not_reach_people():
    with pytest.raises(BadValue, match="expected a report in words"):
        check_playable([Condition(interventions=(Aloud(),), modality="rgb", name="aloud")], PERSON)
    check("nudge + drop?p=0.2 + rgb", PERSON)
