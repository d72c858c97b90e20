"""What a client reads is what other agents read, but for how to reply."""

import json
from dataclasses import replace

import pytest

from lockprobe.agents.prompt import conversation, example
from lockprobe.interfaces.mcp.wording import instruction, observation, reply_form, tool_schema, wording
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Percept


@pytest.mark.parametrize("assessment", [True, False])
def test_the_instruction_is_that_of_the_chat_protocol_but_for_the_reply(assessment):
    situation = example(assessment=assessment)
    chat = conversation(situation)[0].text.splitlines()
    tools = instruction(situation).splitlines()
    assert tools[:3] == chat[:3]
    assert tools[3] == reply_form(assessment=assessment)
    assert ("last_action" in tools[3]) == assessment
    assert "JSON" not in instruction(situation)
    assert tools[4] == chat[-3]
    assert "The panel's joints: B, A. The target joint: A." in tools[4]


def test_a_trial_that_goes_on_tells_its_steps_and_then_what_is_told_now():
    text = instruction(example())
    assert text.endswith("The trial goes on. Your steps so far:\nfirst\n1. You attempted B.\n\nthen")
    assert observation(example()) == "then"


@pytest.mark.parametrize(("pictures", "said"), [(1, "shown a picture of the box"), (2, "one of its depth")])
def test_pictures_are_announced(pictures, said):
    assert said in instruction(example(pictures))


def test_a_report_that_is_dropped_is_no_empty_text():
    assert observation(replace(example(), percept=Percept(joint="B"))) == "(no report)"
    nudged = replace(example(), percept=Percept(joint="B"), briefing=Briefing(remark="Note."))
    assert observation(nudged) == "Note."


def test_the_schema_asks_for_what_the_chat_protocol_asks_for():
    schema = tool_schema(4, assessment=True)
    assert schema["properties"]["joint"]["enum"] == ["A", "B", "C", "D"]
    assert schema["properties"]["last_action"]["enum"] == ["moved", "did not move", "none"]
    assert schema["required"] == ["joint"]
    assert "last_action" not in tool_schema(4, assessment=False)["properties"]
    assert "hypothesis" in schema["properties"]
    assert "hypothesis" not in tool_schema(4, assessment=True, hypothesis=False)["properties"]
    json.dumps(schema)


def test_the_fingerprint_changes_with_what_is_asked():
    asked = ({"assessment": True}, {"assessment": False}, {"assessment": True, "hypothesis": False})
    assert len({*(wording(4, **one) for one in asked), wording(5, assessment=True)}) == 4


def test_a_client_that_nobody_asks_for_a_hypothesis_is_told_of_none():
    unasked = replace(example(), briefing=Briefing(hypothesis="off"))
    assert "hypothesis" in instruction(example())
    assert "hypothesis" not in instruction(unasked)
