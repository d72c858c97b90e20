"""The prompt is the same for every trial and leaks nothing; the conversation grows, and only pictures may leave it."""

import itertools
import re
from dataclasses import replace
from types import MappingProxyType

import pytest

from lockprobe import run_trial, study
from lockprobe.agents import prompt
from lockprobe.agents.local import CONSTANT
from lockprobe.agents.local import UNASKED as UNASKED_LOG
from lockprobe.agents.prompt import conversation, instructions, prompt_fingerprint, repair, reply_schema
from lockprobe.agents.reply import asked_for
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import ReplyFault
from lockprobe.statistics.design import ARMS
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

TASK = Task(joints=("C", "A", "D", "B"), target="D", budget=20)
FIRST = Situation(task=TASK, past=(), percept=Percept(positions=(False,) * 4, text="At 1: none."))
LATER = Situation(
    task=TASK,
    past=(Turn(percept=FIRST.percept, decision=Decision(joint="A", replies=("bad", "good"))),),
    percept=Percept(joint="A", outcome="blocked", positions=(False,) * 4, text="A did not move. At 1: none."),
)
UNASKED = replace(LATER, task=replace(TASK, assessment=False))
TOLD = instructions(FIRST)


def test_what_is_of_one_trial_alone_stands_last_so_that_trials_share_the_rest():
    other = Task(joints=tuple("ABCD"), target="C", budget=20)
    pictures = Percept(pictures=(Picture(kind="rgb", png=b""), Picture(kind="depth", png=b"")))
    for percept in (FIRST.percept, pictures):
        one, another = (instructions(Situation(task=task, past=(), percept=percept)) for task in (TASK, other))
        shared, own = one.rsplit("\n", 1)
        assert another == f"{shared}\nThe panel's joints: A, B, C, D. The target joint: C."
        assert own == "The panel's joints: C, A, D, B. The target joint: D."
        assert len(own) < 0.1 * len(one)


REPORTS = "You are not told whether a joint moved: find out by comparing successive reports."
SEEN = (
    "Before every step you are shown a picture of the box, always taken from the same place; beside every joint its "
    "label is painted on the panel. You are not told whether a joint moved: find out by comparing successive pictures."
)


@pytest.mark.parametrize(
    ("percept", "observation"),
    [
        (Percept(positions=(False,) * 4), "Then you are told whether it moved, and which joints are now at position 1."),
        (Percept(positions=(False,) * 4, in_full=True), "Then you are told whether it moved, and the position of every joint."),
        (Percept(positions=(False,) * 4, states_only=True), f"Then you are told which joints are now at position 1. {REPORTS}"),
        (Percept(), "Then you are told whether it moved."),
        (Percept(pictures=(Picture(kind="rgb", png=b""),)), SEEN),
        (
            Percept(pictures=(Picture(kind="rgb", png=b""), Picture(kind="depth", png=b""))),
            SEEN.replace("a picture of the box", "two pictures of the box, one of its colours and one of its depth"),
        ),
    ],
)  # fmt: skip
def test_only_what_is_said_of_the_observation_follows_the_first_percept(percept, observation):
    """Where pictures are shown, positions have no names, and outcomes are to be inferred."""
    said = conversation(replace(FIRST, percept=percept))[0].text
    before, after = TOLD.split("Then you are told whether it moved, and which joints are now at position 1.")
    before = before.replace("two positions, 0 and 1.", "two positions.") if percept.pictures else before
    assert said == before + observation + after


def test_it_leaks_neither_names_nor_structure_of_the_box():
    text = f"{TOLD} {CONSTANT} {UNASKED_LOG}".lower().replace("in the first step", "")
    words = ["chain", "slider", "revolute", "prismatic", "left", "right", "first", "order", "needs", *box().names]
    assert [word for word in words if word in text] == []


def test_form_and_repair_say_what_can_be_said_and_where_nobody_asks_no_word_of_what_the_last_action_did():
    assert reply_schema(asked_for(FIRST))["properties"]["last_action"]["enum"] == ["none"]
    assert reply_schema(asked_for(LATER))["properties"]["joint"]["enum"] == ["C", "A", "D", "B"]
    again = 'That reply could not be used (why). Reply with one JSON object and nothing else: {{{}"hypothesis": "", "joint": one of ["C", "A", "D", "B"]}}'
    assert repair(ReplyFault("why"), LATER) == again.format('"last_action": "moved" or "did not move", ')
    words = '"last_action": "moved" or "did not move" ("none" in the first step), '
    assert TOLD.replace(words, "") == instructions(UNASKED)
    schema = reply_schema(asked_for(UNASKED))
    assert [*schema["properties"]] == schema["required"] == ["hypothesis", "joint"]
    assert repair(ReplyFault("why"), UNASKED) == again.format("")


def looked(*shown, steps=6):
    """A trial of pictures, of the kinds shown and one that is not; or of reports."""
    percepts = []
    for step in range(steps):
        pictures = [Picture(kind=kind, png=f"{kind} {step}".encode()) for kind in shown]
        hidden = Picture(kind="depth16", png=b"measured", shown=False)
        percepts.append(Percept(joint="A" if step else None, text=f"Look {step}.", pictures=(*pictures, hidden)))
    said = [Decision(joint="A", replies=("bad", f"reply {step}")) for step in range(steps)]
    past = tuple(Turn(percept=one, decision=decision) for one, decision in zip(percepts[:-1], said, strict=False))
    return Situation(task=TASK, past=past, percept=percepts[-1])


@pytest.mark.parametrize(("shown", "images"), [((), 0), (("rgb",), 0), (("rgb", "depth"), 9)])
def test_every_request_begins_with_the_one_before_and_holds_the_reply_that_counted(shown, images):
    requests = [conversation(looked(*shown, steps=steps), images=images) for steps in range(1, 20)][: images or 20]
    for step, (before, after) in enumerate(itertools.pairwise(requests)):
        assert after[:-2] == before
        assert [(message.role, message.text) for message in after[-2:]] == [
            ("assistant", f"reply {step}"), ("user", f"Look {step + 1}."),
        ]  # fmt: skip


@pytest.mark.parametrize("images", [0, 2, 9])
@pytest.mark.parametrize("shown", [("rgb",), ("rgb", "depth")])
def test_the_newest_observations_keep_their_pictures_as_they_are_and_what_is_not_shown_is_never_sent(shown, images):
    told = conversation(looked(*shown), images=images)[::2]
    for step, message in enumerate(told):
        newest = not images or step >= len(told) - images
        assert [one.png for one in message.pictures] == [f"{kind} {step}".encode() for kind in shown if newest]
        assert message.text.endswith("no longer shown)") != newest


@pytest.mark.parametrize(
    ("name", "wording"),
    [
        ("_SEEN", "You are shown {pictures}."),
        ("_PICTURES", {1: "a photograph", 2: "a photograph and its depth"}),
        ("_GONE", {1: "(gone)", 2: "(gone)"}),
        ("INSTRUCTIONS", prompt.INSTRUCTIONS.replace("trying", "asked")),
        ("_OBSERVATION", dict.fromkeys(prompt._OBSERVATION, "You are told all.")),
        ("_ASKED", {**prompt._ASKED, "last_action": "what happened"}),
    ],
)
def test_whatever_is_said_of_reports_or_of_pictures_is_in_the_fingerprint(monkeypatch, name, wording):
    before = prompt_fingerprint()
    monkeypatch.setattr(prompt, name, wording)
    assert prompt_fingerprint() != before


class InTurn:
    """An agent that takes the joints in turn, and keeps what a model would be sent."""

    facts = MappingProxyType({})

    async def decide(self, situation, rng):
        self.messages = [message.text for message in conversation(situation)]
        joint = situation.task.joints[len(situation.past) % 4]
        return Decision(joint=joint, replies=(f'{{"joint": "{joint}"}}',))


def test_every_arm_of_the_study_of_controls_changes_the_reports_of_the_same_steps_and_no_message_names_it():
    """What would tell a model which arm it is in is a word, or an option of a spec."""
    naming = r"\b(truth|true|lies?|false|flips?|distract|condition|arms?|retract)|[?&]\w+="
    sent = {}
    for condition in study("why", agent="random").conditions:
        player = InTurn()
        run_trial(agent=player, condition=condition, trial=2, seed=2)
        sent[condition.label] = player.messages
    assert list(sent) == list(ARMS)
    hit = [at for at, pair in enumerate(zip(sent["lie"], sent["truth"], strict=True)) if len({*pair}) == 2]
    assert len(hit) > 1
    for arm, messages in sent.items():
        differing = [at for at, pair in enumerate(zip(messages, sent["truth"], strict=True)) if len({*pair}) == 2]
        assert differing == ([] if arm == "truth" else hit)
        assert all(at % 2 == 0 for at in differing)  # what it is told, not what it said
        assert re.findall(naming, " ".join(messages).lower()) == []
