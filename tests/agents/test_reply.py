"""A text with one reading is a decision, and what was tidied is named; with none or two it is refused and said why."""

import json
import time
from dataclasses import replace

import pytest

from lockprobe.agents.reply import TIDIED, object_in, parse_reply, spoken, without_marks
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.record import Briefing, Percept, Situation, Task

TASK = Task(joints=("C", "A", "B", "left slider"), target="C", budget=20)
FIRST = Situation(task=TASK, past=(), percept=Percept())
LATER = replace(FIRST, percept=Percept(joint="A", outcome="blocked"))
UNASKED = replace(LATER, task=replace(TASK, assessment=False))
FIELDS = {"last_action": "moved", "hypothesis": "B's lock", "joint": "B"}
OBJECT = json.dumps(FIELDS)
OTHER = json.dumps(FIELDS | {"joint": "C"})
TURN = f"{OBJECT}<|im_end|>\n<|im_start|>user\nB moved.<|im_end|>\n<|im_start|>assistant\n{OTHER}"
HARMONY = f"<|channel|>analysis<|message|>Perhaps {OTHER}<|end|><|start|>assistant<|channel|>final<|message|>{OBJECT}<|return|>"

ONE_READING = {
    OBJECT: (),
    f" \n{OBJECT}\n": (),
    f"\ufeff{OBJECT}": ("text",),
    f"<think>Perhaps {OTHER}</think>{OBJECT}": ("marks",),
    f"<think>a <think> b</think> c</think>\n{OBJECT}": ("marks",),
    f"Perhaps {OTHER}\n</think>\n{OBJECT}": ("marks",),
    f"<THOUGHT>Hm</THOUGHT> {OBJECT}": ("marks",),
    f'<thinking budget="9">Hm</thinking>{OBJECT}': ("marks",),
    f"<reasoning>Hm</reasoning>{OBJECT}": ("marks",),
    f"<seed:think>Hm</seed:think>{OBJECT}": ("marks",),
    f"[THINK]Hm[/THINK]{OBJECT}": ("marks",),
    f"◁think▷Hm◁/think▷{OBJECT}": ("marks",),
    f"<think>{OBJECT}": ("marks",),
    f"<think>\n{OBJECT}\n</think>": ("marks",),
    HARMONY: ("marks",),
    HARMONY.replace("final<", "final <|constrain|>json<"): ("marks",),
    f"<|channel|>final<|message|>{OBJECT}": ("marks",),
    f"{OBJECT}<|im_end|>": ("marks",),
    f"<|channel>thought\nPerhaps {OTHER}<channel|>{OBJECT}<turn|>": ("marks",),
    f"<|begin_of_box|>{OBJECT}<|end_of_box|>": ("marks",),
    f"{OBJECT}<|eot_id|>": ("marks",),
    f"<s>{OBJECT}</s>": ("marks",),
    f"{OBJECT}<end_of_turn>\n": ("marks",),
    f"[/INST] {OBJECT}": ("marks",),
    f"{OBJECT}<\uff5cend▁of▁sentence\uff5c>": ("marks",),
    TURN: ("marks",),
    f"<|start_header_id|>assistant<|end_header_id|>\n\n{OBJECT}": ("marks", "text"),
    f"assistant\n{OBJECT}": ("text",),
    f"I choose: {OBJECT} That is all.": ("text",),
    f"The set {{A, B}} is done. {OBJECT}": ("text",),
    f"[{OBJECT}]": ("text",),
    f"```json\n{OBJECT}\n```": ("text",),
    f"```JSON\n{OBJECT}\n```": ("text",),
    f"``` json5\n{OBJECT}\n```": ("text",),
    f"~~~jsonc\n{OBJECT}\n~~~": ("text",),
    f"Here:\n```json\n{OBJECT}\n```\nDone.": ("text",),
    f"{OBJECT}\n{OBJECT}": ("text",),
    f"```\n{OBJECT}\n```\n{json.dumps(FIELDS, indent=1)}": ("text",),
    f'{OBJECT[:-1]}, "joint": "B"}}': ("syntax",),
    f"{OBJECT[:-1]},}}": ("syntax",),
    f'{{"reply": {OBJECT}}}': ("text",),
    f'{{"name": "reply", "arguments": {OBJECT}}}': ("text",),
    f'<tool_call>\n{{"name": "reply", "arguments": {OBJECT}}}\n</tool_call>': ("text",),
    f"{{{OBJECT}}}": ("text",),
    f"\\boxed{{{OBJECT}}}": ("text",),
    f"<analysis>Perhaps {OTHER}</analysis>{OBJECT}": ("marks",),
    f"<reason>Perhaps {OTHER}</reason>{OBJECT}": ("marks",),
    "{'last_action': 'moved', 'hypothesis': 'B\\'s lock', 'joint': 'B'}": ("syntax",),
    OBJECT.replace("last_action", "lastAction").replace("joint", "Joint"): ("spelling",),
}


@pytest.mark.parametrize(("text", "tidied"), ONE_READING.items())
def test_a_text_with_one_reading_is_a_decision_and_what_was_tidied_is_named(text, tidied):
    decision = parse_reply(text, LATER)
    assert (decision.joint, decision.claimed, decision.hypothesis) == ("B", "moved", "B's lock")
    assert decision.replies == (text,)
    assert decision.tidied == tuple(sorted(tidied, key=TIDIED.index))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "an empty reply"),
        (" \n", "an empty reply"),
        ("<think>Hm", "reasoning without a reply after it"),
        (f"<think>Perhaps {OBJECT}", "reasoning without a reply after it"),
        (f"{OBJECT}<think>Perhaps {OTHER}</think>", "reasoning without a reply after it"),
        (f"Perhaps {OBJECT}</think>", "reasoning without a reply after it"),
        (HARMONY.replace("final", "commentary"), "reasoning without a reply after it"),
        ("B", "not one JSON object"),
        ('{"set": ["A"]} B', "not one JSON object"),
        (f"{OBJECT}\n{OTHER}", "JSON objects that differ"),
        (f"The form is {OTHER}, so {OBJECT}", "JSON objects that differ"),
        (f"{OBJECT} or C", "a JSON object and an alternative"),
        (f"C or {OBJECT}", "a JSON object and an alternative"),
        (f"```json\n{OTHER}\n```\nor rather\n```json\n{OBJECT}\n```", "JSON objects that differ"),
        (f'{{"joint" "C"}} {OBJECT}', "not one JSON object"),
        (f'Like {{"joint": "A" or "B"}}: {OBJECT}', "not one JSON object"),
        (f"{{{OBJECT}, {OTHER}}}", "JSON objects that differ"),
        (f'I choose {OTHER[:-1]}, "rather": {OBJECT}}}', "not one JSON object"),
        (f'{{"plan": {OBJECT}', "a JSON object that does not end"),
        (f"{OBJECT} {{", "a JSON object that does not end"),
        (f'{OBJECT[:-1]}, "joint": "C"}}', "joint: two values"),
        (f'{OBJECT[:-1]}, "Joint": "C"}}', "joint: two values"),
        ("[" * 100_000, "not one JSON object"),
        ('{"a":' * 50_000 + "1" + "}" * 50_000, "not one JSON object"),
        ('["moved", "B"]', "not one JSON object"),
        ("{'joint': 'B', 'joint': 'C'}", "joint: two values"),
        ("{'joint': 'B', **FIELDS}", "not one JSON object"),
        (json.dumps(FIELDS | {"hypothesis": "x" * 4001}), "hypothesis: 4001 characters, at most 4000"),
        ('{"joint": "B"}', "last_action: Field required"),
        ('{"last_action": null, "joint": "B"}', "last_action: Field required"),
        ('{"last_action": "moved", "joint": null}', "joint: Field required"),
        ('{"last_action": "none", "joint": "B"}', "last_action: 'none' is none of moved, did not move"),
        ('{"last_action": "moved", "joint": 3}', "joint: 3 is none of C, A, B, left slider"),
    ],
)
def test_a_text_with_none_or_two_readings_is_refused_and_said_why(text, why):
    with pytest.raises(ReplyFault) as fault:
        parse_reply(text, LATER)
    assert str(fault.value) == why


def read(now=LATER, **fields):
    return parse_reply(json.dumps({"last_action": "moved", "hypothesis": "", "joint": "B"} | fields), now)


@pytest.mark.parametrize(
    ("name", "value", "meant"),
    [
        *(("joint", value, "A") for value in ("a", " A ", "'A'", "A.", "joint A", "the A", "the joint A", "A!", ["A"])),
        *(("joint", value, "left slider") for value in ("Left Slider", "left_slider", "LEFT-SLIDER", "leftSlider")),
        *(("joint", f"left{hyphen}slider", "left slider") for hyphen in "\u2010\u2011\u2012\u2013\u2014\u2212"),
        *(("claimed", value, "moved") for value in ("Moved", "moved.", "MOVED", "it moved", "A moved", ["moved"])),
        *(("claimed", value, "blocked") for value in ("did not move.", "Did_Not-Move", "didn't move", "didn\u2019t move")),
        *(("claimed", value, "blocked") for value in ("It did not move!", "Joint A did not move", "not moved")),
        *(("claimed", value, None) for value in ("None", "none.", None, "", "null")),
        ("hypothesis", None, ""),
        ("hypothesis", ["A", "B"], "['A', 'B']"),
        ("hypothesis", "it\ud83d opens", "it? opens"),
    ],
)  # fmt: skip
def test_another_spelling_is_read_and_noted(name, value, meant):
    """In the first step there is one claim, however it is spelled."""
    decision = read(FIRST if meant is None else LATER, **{"last_action" if name == "claimed" else name: value})
    assert (getattr(decision, name), decision.tidied) == (meant, ("spelling",))
    assert (
        read(hypothesis="x" * 4000).tidied == parse_reply('{"last_action": "moved", "joint": "B"}', LATER).tidied == ()
    )


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("joint", value) for value in ("A or B", "A, B", "AB", "", "D", ["A", "B"], {"A": "B"}, True, 1.5, "\u0410")),
        *(("last_action", value) for value in ("moved or did not move", "B moved", "none", True, "true", "yes", 1, "")),
    ],
)
def test_a_value_that_has_no_reading_or_two_is_refused_by_its_name(name, value):
    with pytest.raises(ReplyFault, match=f"^{name}: "):
        read(**{name: value})
    with pytest.raises(ReplyFault, match="^last_action: 'moved' is none of none$"):
        read(FIRST)


def test_labels_that_differ_in_what_does_not_matter_are_told_apart_or_refused():
    now = replace(UNASKED, task=Task(joints=("a", "A", "a-1", "a1"), target="a", budget=9, assessment=False))
    for joint in now.task.joints:
        assert read(now, joint=joint).joint == joint
    for joint in ("A.", "A 1"):
        with pytest.raises(ReplyFault, match="^joint: "):
            read(now, joint=joint)


@pytest.mark.parametrize("volunteered", [{}, {"last_action": "moved"}, {"last_action": "perhaps"}])
def test_what_nobody_asks_for_is_neither_needed_nor_read(volunteered):
    decision = parse_reply(json.dumps(volunteered | {"hypothesis": "h", "joint": "B"}), UNASKED)
    assert (decision.joint, decision.claimed, decision.hypothesis) == ("B", None, "h")
    mute = replace(UNASKED, briefing=Briefing(hypothesis="off"))
    assert parse_reply('{"joint": "B", "hypothesis": "h"}', mute).hypothesis == ""


@pytest.mark.parametrize("piece", ["{", "<think>", '{"', "{'", "/*", "<|channel|>", "```", "[INST]", "</think>a"])
def test_the_longest_replies_of_any_kind_take_no_longer_than_a_moment(piece):
    began = time.process_time()
    for text in (piece * (100_000 // len(piece)), "{" + piece * 20_000 + "}"):
        try:
            object_in(text, [*FIELDS])
        except ReplyFault:
            without_marks(text)
    assert time.process_time() - began < 2


def test_text_without_marks_stands_in_the_conversation_as_it_is():
    tagged = json.dumps({"hypothesis": "the </think> tag", "joint": "A"})
    for text in ("a reply\n", f" {OBJECT}", "a < b", "[A]", tagged):
        assert (spoken(text), without_marks(text)) == (text, text)
    assert spoken("<think>Hm") == "(empty)"
