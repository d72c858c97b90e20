"""The prompt is the same for every trial and leaks nothing; all that is asked for is said in it."""

import itertools
from dataclasses import replace

import pytest

from lockprobe.agents import prompt
from lockprobe.agents.prompt import (
    chat_fingerprint,
    conversation,
    instructions,
    picture_fingerprint,
    repair,
    reply_schema,
)
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

TASK = Task(joints=("C", "A", "D", "B"), target="D", budget=20)
FIRST = Situation(task=TASK, past=(), percept=Percept(positions=(False,) * 4, text="At 1: none."))
LATER = Situation(
    task=TASK,
    past=(Turn(percept=FIRST.percept, decision=Decision(joint="A", replies=("bad", "good"))),),
    percept=Percept(joint="A", outcome="blocked", positions=(False,) * 4, text="A did not move. At 1: none."),
)


def test_what_is_of_one_trial_alone_stands_last_so_that_trials_share_the_rest():
    other = Task(joints=tuple("ABCD"), target="C", budget=20)
    for settings in ({"positions": True}, {"positions": False, "pictures": 2}):
        one, another = instructions(TASK, **settings), instructions(other, **settings)
        shared, own = one.rsplit("\n", 1)
        assert another == f"{shared}\nThe panel's joints: A, B, C, D. The target joint: C."
        assert own == "The panel's joints: C, A, D, B. The target joint: D."
        assert len(own) < 0.1 * len(one)


def test_only_the_observation_sentence_follows_the_modality():
    told, hidden = instructions(TASK, positions=True), instructions(TASK, positions=False)
    assert told.replace(", and which joints are now at position 1", "") == hidden


def test_where_pictures_are_shown_positions_have_no_names_and_outcomes_are_to_be_inferred():
    told, seen = instructions(TASK, positions=True), instructions(TASK, positions=False, pictures=1)
    words = "Then you are told whether it moved, and which joints are now at position 1."
    before, after = told.replace("two positions, 0 and 1.", "two positions.").split(words)
    assert seen.startswith(before)
    assert seen.endswith(after)
    said = seen[len(before) : -len(after)]
    assert "a picture of the box, always taken from the same place" in said
    assert "its label is painted" in said
    assert "not told whether a joint moved: find out by comparing successive pictures." in said
    both = instructions(TASK, positions=False, pictures=2)
    assert both == seen.replace(
        "a picture of the box", "two pictures of the box, one of its colours and one of its depth"
    )


def test_it_leaks_neither_names_nor_structure_of_the_box():
    text = instructions(TASK, positions=True).lower()
    words = ["chain", "slider", "revolute", "prismatic", "left", "right", "first", "order", *box().names]
    assert [word for word in words if word in text.replace("in the first step", "")] == []
    for one, other in itertools.permutations("CADB", 2):
        assert f"{one} needs {other}".lower() not in text


def test_the_conversation_holds_what_was_told_and_the_reply_that_counted():
    texts = [(message.role, message.text) for message in conversation(LATER)]
    assert texts[0][1].endswith("At 1: none.")
    assert texts[1:] == [("assistant", "good"), ("user", "A did not move. At 1: none.")]


def test_the_schema_offers_what_can_be_said():
    assert reply_schema(FIRST)["properties"]["last_action"]["enum"] == ["none"]
    assert reply_schema(LATER)["properties"]["joint"]["enum"] == ["C", "A", "D", "B"]


UNASKED = replace(LATER, task=replace(TASK, assessment=False))


def test_where_nobody_asks_what_the_last_action_did_neither_prompt_nor_form_nor_repair_says_a_word_of_it():
    asked, unasked = instructions(TASK, positions=True), instructions(UNASKED.task, positions=True)
    words = '"last_action": "moved" or "did not move" ("none" in the first step), '
    assert asked.replace(words, "") == unasked
    schema = reply_schema(UNASKED)
    assert [*schema["properties"]] == schema["required"] == ["hypothesis", "joint"]
    said = repair(ReplyFault("why"), UNASKED)
    assert "last_action" not in said
    assert '{"hypothesis": "", "joint": one of ["C", "A", "D", "B"]}' in said
    assert '{"last_action": "moved" or "did not move", "hypothesis": "", "joint"' in repair(ReplyFault("why"), LATER)


def test_every_request_of_a_trial_begins_with_the_one_before():
    situation, requests = FIRST, []
    for step in range(1, 20):
        requests.append(conversation(situation))
        turn = Turn(percept=situation.percept, decision=Decision(joint="A", replies=("bad", f"reply {step}")))
        told = Percept(joint="A", outcome="blocked", positions=(False,) * 4, text=f"A did not move {step}.")
        situation = Situation(task=TASK, past=(*situation.past, turn), percept=told)
    for before, after in itertools.pairwise(requests):
        assert after[: len(before)] == before
        assert len(after) == len(before) + 2


@pytest.mark.parametrize("images", [0, 9])
def test_so_do_those_with_pictures_as_long_as_none_leaves_the_conversation(images):
    whole = looked("rgb")
    for step in range(1, 6):
        before = Situation(task=TASK, past=whole.past[: step - 1], percept=whole.past[step - 1].percept)
        earlier = conversation(before, images=images)
        assert conversation(whole, images=images)[: len(earlier)] == earlier


def looked(*shown):
    """Six steps of pictures, of the kinds shown and one that is not."""
    percepts = []
    for step in range(6):
        pictures = [Picture(kind=kind, png=f"{kind} {step}".encode()) for kind in shown]
        hidden = Picture(kind="depth16", png=b"measured", shown=False)
        percepts.append(Percept(joint="A" if step else None, text=f"Look {step}.", pictures=(*pictures, hidden)))
    past = tuple(Turn(percept=percept, decision=Decision(joint="A", replies=("good",))) for percept in percepts[:-1])
    return Situation(task=TASK, past=past, percept=percepts[-1])


def test_pictures_stay_with_the_observation_that_showed_them_and_hidden_ones_are_kept_back():
    messages = [message for message in conversation(looked("rgb", "depth")) if message.role == "user"]
    assert [[p.png.decode() for p in m.pictures] for m in messages] == [[f"rgb {i}", f"depth {i}"] for i in range(6)]
    assert messages[0].text == instructions(TASK, positions=False, pictures=2) + "\n\nLook 0."
    assert [message.text for message in messages[1:]] == [f"Look {i}." for i in range(1, 6)]


@pytest.mark.parametrize(("shown", "gone"), [(("rgb",), "(picture no"), (("rgb", "depth"), "(pictures no")])
@pytest.mark.parametrize("images", [1, 4, 6, 9])
def test_only_the_newest_observations_keep_their_pictures(images, shown, gone):
    messages = [message for message in conversation(looked(*shown), images=images) if message.role == "user"]
    whole = [message for message in conversation(looked(*shown)) if message.role == "user"]
    assert messages[-images:] == whole[-images:]
    for message, full in list(zip(messages, whole, strict=True))[:-images]:
        assert message.pictures == ()
        assert message.text == f"{full.text} {gone} longer shown)"


def test_reports_are_told_as_ever_whatever_is_asked_of_pictures():
    assert conversation(LATER, images=1) == conversation(LATER)
    assert all(message.pictures == () for message in conversation(LATER))


def test_what_is_told_is_said_as_the_first_percept_has_it():
    said = {
        tell: conversation(Situation(task=TASK, past=(), percept=percept))[0].text
        for tell, percept in {
            "both": Percept(positions=(False,) * 4),
            "state": Percept(positions=(False,) * 4, states_only=True),
            "outcome": Percept(),
        }.items()
    }
    assert "Then you are told whether it moved, and which joints are now at position 1." in said["both"]
    assert "Then you are told whether it moved.\n" in said["outcome"]
    compare = "You are not told whether a joint moved: find out by comparing successive reports."
    assert f"Then you are told which joints are now at position 1. {compare}\n" in said["state"]


@pytest.mark.parametrize(
    ("name", "wording", "changed"),
    [
        ("_SEEN", "You are shown {pictures}.", (False, True)),
        ("_PICTURES", {1: "a photograph", 2: prompt._PICTURES[2]}, (False, True)),
        ("_PICTURES", {1: prompt._PICTURES[1], 2: "a photograph and its depth"}, (False, True)),
        ("_GONE", {1: "(gone)", 2: prompt._GONE[2]}, (False, True)),
        ("_GONE", {1: prompt._GONE[1], 2: "(gone)"}, (False, True)),
        ("INSTRUCTIONS", prompt.INSTRUCTIONS.replace("trying", "asked"), (True, True)),
        ("_OBSERVATION", dict.fromkeys(prompt._OBSERVATION, "You are told all."), (True, False)),
    ],
)
def test_what_is_said_of_reports_and_of_pictures_has_a_fingerprint_of_its_own(monkeypatch, name, wording, changed):
    before = chat_fingerprint(), picture_fingerprint()
    monkeypatch.setattr(prompt, name, wording)
    assert (chat_fingerprint() != before[0], picture_fingerprint() != before[1]) == changed
