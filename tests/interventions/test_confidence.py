"""How sure a model is, and whether it thinks the report false."""

from dataclasses import replace

import pytest

from lockprobe.agents.prompt import conversation, example, parse_reply, repair, reply_schema
from lockprobe.foundation.errors import BadValue, ReplyFault
from lockprobe.interventions.confidence import Confidence
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Decision
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

BRIEFING = Confidence().brief(Briefing(), (), example().task, None)
LATER = replace(example(), briefing=BRIEFING)
FIRST = replace(LATER, percept=LATER.past[0].percept, past=())
REPLY = '{"last_action": "moved", "confidence": 70, "report_false": true, "hypothesis": "", "joint": "B"}'


def test_it_is_asked_in_every_step_but_the_first():
    assert list(reply_schema(LATER)["properties"]) == [
        "last_action",
        "confidence",
        "report_false",
        "hypothesis",
        "joint",
    ]
    assert list(reply_schema(FIRST)["properties"]) == ["last_action", "hypothesis", "joint"]
    assert '"confidence": how sure you are' in conversation(FIRST)[0].text
    assert '"confidence": 0 to 100, "report_false": true or false' in repair(ReplyFault("why"), LATER)


def test_what_is_said_is_in_the_decision():
    decision = parse_reply(REPLY, LATER)
    assert (decision.confidence, decision.report_false) == (70, True)
    unasked = parse_reply(REPLY, example())
    assert (unasked.confidence, unasked.report_false) == (None, None)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [("70", "101", "confidence: 101 is no whole number"), ('"confidence": 70, ', "", "confidence: Field required"),
     ("true", "2", "report_false: 2 is neither"), ('"report_false": true, ', "", "report_false: Field required")],
)  # fmt: skip
def test_a_reply_without_usable_answers_is_asked_for_again(before, after, said):
    with pytest.raises(ReplyFault, match=said):
        parse_reply(REPLY.replace(before, after), LATER)


class Sure:
    """Says that it is as sure as it is made, and that every report is false."""

    def __init__(self, sure=70):
        self.sure, self.facts = sure, {}

    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[0], confidence=self.sure, report_false=True)


def test_it_is_in_the_record_where_it_was_asked_and_nowhere_else():
    asked, unasked = (run_trial(agent=Sure(), condition=condition) for condition in ("confidence", ""))
    assert {(step.decision.confidence, step.decision.report_false) for step in asked.steps} == {(70, True)}
    assert b'"confidence":70,"report_false":true' in trial_to_json(asked)
    assert trial_from_json(trial_to_json(asked)) == asked
    assert b"confidence" not in trial_to_json(unasked)


@pytest.mark.parametrize("sure", [101, -1, 0.5, "very"])
def test_numbers_that_none_can_be_end_the_trial_as_an_error(sure):
    trial = run_trial(agent=Sure(sure), condition="confidence")
    assert trial.error.boundary == "reply"
    with pytest.raises(BadValue):
        trial_from_json(trial_to_json(run_trial(agent=Sure(), condition="confidence")).replace(b":70,", b":170,"))


def test_who_is_not_asked_what_happened_is_not_asked_how_sure_it_is():
    with pytest.raises(BadValue, match="confidence cannot be combined with --no-assessment"):
        run_trial(agent="random", condition="confidence", assessment=False)
