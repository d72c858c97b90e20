"""What has one reading is read, and what was tidied is named; what has two readings is refused."""

import json
import time

import pytest

from lockprobe.agents.reply_text import TIDIED, mark_in, object_in, plain_form, without_marks
from lockprobe.foundation.errors import ReplyFault

NAMES = ["last_action", "hypothesis", "joint"]
FIELDS = {"last_action": "moved", "hypothesis": "B's lock", "joint": "B"}
OBJECT = json.dumps(FIELDS)
OTHER = json.dumps(FIELDS | {"joint": "C"})
TURN = f"{OBJECT}<|im_end|>\n<|im_start|>user\nB moved.<|im_end|>\n<|im_start|>assistant\n{OTHER}"
HARMONY = f"<|channel|>analysis<|message|>Perhaps {OTHER}<|end|><|start|>assistant<|channel|>final<|message|>{OBJECT}<|return|>"

ONE_READING = {
    OBJECT: (),
    f" \n{OBJECT}\n": (),
    f"\ufeff{OBJECT}": ("prose",),
    f"<think>Perhaps {OTHER}</think>{OBJECT}": ("reasoning",),
    f"<think>a <think> b</think> c</think>\n{OBJECT}": ("reasoning",),
    f"Perhaps {OTHER}\n</think>\n{OBJECT}": ("reasoning",),
    f"{OBJECT}<think>Perhaps {OTHER}</think>": ("reasoning",),
    f"<THOUGHT>Hm</THOUGHT> {OBJECT}": ("reasoning",),
    f'<thinking budget="9">Hm</thinking>{OBJECT}': ("reasoning",),
    f"<reasoning>Hm</reasoning>{OBJECT}": ("reasoning",),
    f"<seed:think>Hm</seed:think>{OBJECT}": ("reasoning",),
    f"[THINK]Hm[/THINK]{OBJECT}": ("reasoning",),
    f"◁think▷Hm◁/think▷{OBJECT}": ("reasoning",),
    f"<think>{OBJECT}": ("reasoning",),
    f"<think>\n{OBJECT}\n</think>": ("reasoning",),
    HARMONY: ("reasoning",),
    HARMONY.replace("final<", "final <|constrain|>json<"): ("reasoning",),
    f"<|channel|>final<|message|>{OBJECT}": ("template",),
    f"analysisPerhaps {OTHER}assistantfinal{OBJECT}": ("reasoning",),
    f"{OBJECT}<|im_end|>": ("template",),
    f"<|channel>thought\nPerhaps {OTHER}<channel|>{OBJECT}<turn|>": ("reasoning", "template"),
    f"<|begin_of_box|>{OBJECT}<|end_of_box|>": ("template",),
    f"{OBJECT}<|eot_id|>": ("template",),
    f"<s>{OBJECT}</s>": ("template",),
    f"{OBJECT}<end_of_turn>\n": ("template",),
    f"[/INST] {OBJECT}": ("template",),
    f"{OBJECT}<\uff5cend▁of▁sentence\uff5c>": ("template",),
    TURN: ("template",),
    f"<|start_header_id|>assistant<|end_header_id|>\n\n{OBJECT}": ("template", "prose"),
    f"assistant\n{OBJECT}": ("prose",),
    f"I choose: {OBJECT} That is all.": ("prose",),
    f"The set {{A, B}} is done. {OBJECT}": ("prose",),
    f"[{OBJECT}]": ("prose",),
    f"```json\n{OBJECT}\n```": ("fence",),
    f"```JSON\n{OBJECT}\n```": ("fence",),
    f"``` json5\n{OBJECT}\n```": ("fence",),
    f"~~~jsonc\n{OBJECT}\n~~~": ("fence",),
    f"Here:\n```json\n{OBJECT}\n```\nDone.": ("fence", "prose"),
    f"{OBJECT}\n{OBJECT}": ("repeated",),
    f"```\n{OBJECT}\n```\n{json.dumps(FIELDS, indent=1)}": ("fence", "repeated"),
    f'{OBJECT[:-1]}, "joint": "B"}}': ("repeated",),
    f"{OBJECT[:-1]},}}": ("syntax",),
    json.dumps(OBJECT): ("syntax",),
    f'{{"reply": {OBJECT}}}': ("syntax",),
    f'{{"name": "reply", "arguments": {OBJECT}}}': ("syntax",),
    f'<tool_call>\n{{"name": "reply", "arguments": {OBJECT}}}\n</tool_call>': ("syntax", "prose"),
    f"{{{OBJECT}}}": ("syntax",),
    f"\\boxed{{{OBJECT}}}": ("syntax", "prose"),
    f"<analysis>Perhaps {OTHER}</analysis>{OBJECT}": ("reasoning",),
    f"<reason>Perhaps {OTHER}</reason>{OBJECT}": ("reasoning",),
    "{'last_action': 'moved', 'hypothesis': 'B\\'s lock', 'joint': 'B'}": ("syntax",),
    '{last_action: "moved", hypothesis: "B\'s lock", joint: "B"} // so': ("syntax", "prose"),
    '{"last_action": "moved", /* it did */ "hypothesis": "B\'s lock",\n "joint": B}': ("syntax",),
    "{\u201clast_action\u201d: \u201cmoved\u201d, \u201chypothesis\u201d: \u201cB's lock\u201d, \u201cjoint\u201d: \u201cB\u201d}": (
        "syntax",
    ),
    OBJECT.replace("last_action", "lastAction").replace("joint", "Joint"): ("spelling",),
}


@pytest.mark.parametrize(("text", "tidied"), ONE_READING.items())
def test_a_reply_with_one_reading_is_read_and_what_was_tidied_is_named(text, tidied):
    found = object_in(text, NAMES)
    assert found.fields == FIELDS
    assert sorted(found.tidied) == sorted(tidied)
    assert set(found.tidied) <= set(TIDIED)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "an empty reply"),
        (" \n", "an empty reply"),
        ("<think>Hm", "reasoning without a reply after it"),
        (f"<think>Perhaps {OBJECT}", "reasoning without a reply after it"),
        (f"Perhaps {OBJECT}</think>", "reasoning without a reply after it"),
        (HARMONY.replace("final", "commentary"), "reasoning without a reply after it"),
        ("B", "not one JSON object"),
        ('{"set": ["A"]} B', "not one JSON object"),
        (f"{OBJECT}\n{OTHER}", "JSON objects that differ"),
        (f"The form is {OTHER}, so {OBJECT}", "JSON objects that differ"),
        (f"```json\n{OTHER}\n```\nor rather\n```json\n{OBJECT}\n```", "JSON objects that differ"),
        (f'{{"joint" "C"}} {OBJECT}', "not one JSON object"),
        (f'Like {{"joint": "A" or "B"}}: {OBJECT}', "not one JSON object"),
        (f"{{{OBJECT}, {OTHER}}}", "not one JSON object"),
        (f"{OBJECT} or C", "a JSON object and an alternative"),
        (f"C or {OBJECT}", "a JSON object and an alternative"),
        (f'{{"plan": {OBJECT}', "a JSON object that does not end"),
        (f"{OBJECT} {{", "a JSON object that does not end"),
        (f'{OBJECT[:-1]}, "joint": "C"}}', "joint: two values"),
        (f'{OBJECT[:-1]}, "Joint": "C"}}', "joint: two values"),
        ("[" * 100_000, "not one JSON object"),
        ('{"a":' * 50_000 + "1" + "}" * 50_000, "not one JSON object"),
    ],
)
def test_a_reply_with_none_or_two_readings_is_refused_and_said_why(text, why):
    with pytest.raises(ReplyFault) as fault:
        object_in(text, NAMES)
    assert str(fault.value) == why


@pytest.mark.parametrize(
    "piece", ["{", "<think>", '{"', "{'", "/*", "<|channel|>", "assistantfinal", "```", "[INST]", "</think>a"]
)
def test_the_longest_replies_of_any_kind_take_no_longer_than_a_moment(piece):
    began = time.process_time()
    for text in (piece * (100_000 // len(piece)), "{" + piece * 20_000 + "}"):
        try:
            object_in(text, NAMES)
        except ReplyFault:
            without_marks(text)
    assert time.process_time() - began < 2


def test_text_without_marks_is_left_as_it_is():
    for text in (
        "a reply\n",
        f" {OBJECT}",
        "a < b",
        "[A]",
        json.dumps({"hypothesis": "the </think> tag", "joint": "A"}),
    ):
        assert without_marks(text) == (text, ())


def test_the_first_mark_is_quoted():
    assert mark_in(f"Hm</think>{OBJECT}<|im_end|>") == "</think>"
    assert mark_in(f"{OBJECT}<|im_end|>") == "<|im_end|>"
    assert mark_in(f"analysisHm.assistantfinal{OBJECT}") == "assistantfinal"


def test_names_are_compared_without_what_does_not_matter():
    assert {
        plain_form(name)
        for name in ("left_slider", "Left-Slider", "left\u2011slider", " left slider. ", "'LEFT SLIDER'")
    } == {"leftslider"}
    assert plain_form("\uff21") == "a"
    assert plain_form("A1") != plain_form("A2")
