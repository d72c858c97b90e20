"""When a model says how the box works, if it is asked at all."""

from dataclasses import replace

import pytest

from lockprobe.agents.prompt import conversation, example, instructions, parse_reply, repair, reply_schema
from lockprobe.foundation.errors import BadValue, ReplyFault
from lockprobe.interventions.hypothesis import Hypothesis
from lockprobe.trial.briefing import Briefing


def asked(ask):
    return replace(example(), briefing=Hypothesis(ask=ask).brief(Briefing(), (), None, None))


@pytest.mark.parametrize(
    ("ask", "keys"),
    [
        ("before", ["last_action", "hypothesis", "joint"]),
        ("after", ["last_action", "joint", "hypothesis"]),
        ("off", ["last_action", "joint"]),
    ],
)
def test_form_instruction_and_repair_ask_in_the_same_order(ask, keys):
    situation = asked(ask)
    schema = reply_schema(situation)
    assert list(schema["properties"]) == schema["required"] == keys
    for text in (conversation(situation)[0].text, repair(ReplyFault("why"), situation)):
        places = [text.find(f'"{key}"') for key in ("last_action", "joint", "hypothesis")]
        assert sorted(keys, key=lambda key: text.find(f'"{key}"')) == keys
        assert (places[2] == -1) == (ask == "off")


def test_before_is_what_everybody_is_asked():
    assert asked("before") == example()


def test_what_nobody_asked_for_is_not_kept():
    reply = '{"last_action": "moved", "hypothesis": "a chain", "joint": "B"}'
    assert [parse_reply(reply, asked(ask)).hypothesis for ask in ("before", "after", "off")] == ["a chain"] * 2 + [""]


def test_nothing_else_of_the_instruction_changes():
    plain, off = (instructions(example().task, positions=True, briefing=asked(a).briefing) for a in ("before", "off"))
    assert plain.replace('"hypothesis": a short sentence on how the box works or "", ', "") == off


def test_another_time_is_refused():
    with pytest.raises(BadValue, match="ask: got 'never', expected one of before, after, off"):
        Hypothesis(ask="never")
