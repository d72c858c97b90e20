"""How large a request is: never larger than was said, and how much of it repeats the one before."""

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from prefixes import repeated_prefix

from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.llm.token_bounds import MOST_OUTPUT, MOST_PER_PICTURE, at_most, tokens
from lockprobe.agents.prompt import Message, conversation, example, repair, reply_schema
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

KNOWN = ModelFacts(reasons=False, most_output=16_384)
ASKED = Message(role="user", text="What now?")
REPLY = Message(role="assistant", text='{"joint": "A"}')
TOLD = Message(role="user", text="A did not move.")


def trial(steps, *, pictures=0, images=0, repaired=False):
    """The requests of a made-up trial."""
    task, past, requests = Task(joints=("A", "B"), target="B", budget=steps), (), []
    shown = tuple(Picture(kind="rgb", png=bytes([i])) for i in range(pictures))
    for step in range(steps):
        told = Percept(joint="A" if step else None, text=f"Told {step}.", pictures=shown)
        situation = Situation(task=task, past=past, percept=told)
        messages = conversation(situation, images=images)
        requests.append(messages)
        if repaired:
            words = repair(ReplyFault("why"), situation)
            requests.append([*messages, Message(role="assistant", text="no"), Message(role="user", text=words)])
        past = (*past, Turn(percept=told, decision=Decision(joint="A", replies=('{"joint": "A"}',))))
    return requests


def test_no_call_takes_more_than_was_said():
    """Tokens of a byte-level tokenizer are at most the bytes; the local model's own count stands beside it."""
    engine = pytest.importorskip("lockprobe.agents.engine")
    weights = pytest.importorskip("lockprobe.agents.weights")
    if weights.find(weights.EMBEDDED) is None:
        pytest.skip("the embedded model is not installed")
    counts = engine.Engine(weights.locate("llm:local"), context=256)
    texts = [*(message.text for message in conversation(example())), "}{][,,;;" * 20, "Verklemmt 🔒 锁住了 " * 20]
    for text in texts:
        said = at_most([Message(role="user", text=text)], ModelSettings(), KNOWN).input_tokens
        assert len(counts.tokens(text)) + len(counts.tokens(str(reply_schema(example())))) <= said
    ours = "".join(texts[:3])
    assert len(counts.tokens(ours)) == pytest.approx(tokens(ours), rel=0.3)


def test_what_a_reply_may_take_is_what_is_asked_for():
    assert at_most([ASKED], ModelSettings(max_tokens=55), KNOWN).output_tokens == 55
    for settings, facts in ((ModelSettings(), KNOWN), (ModelSettings(), ModelFacts(reasons=True))):
        assert at_most([ASKED], settings, facts).output_tokens == settings.parameters(facts)["max_tokens"]
    assert at_most([ASKED], ModelSettings(), ModelFacts()).output_tokens == MOST_OUTPUT
    assert at_most([ASKED], ModelSettings(), ModelFacts(most_output=900)).output_tokens == 900


def test_pictures_count():
    seen = replace(ASKED, pictures=(Picture(kind="rgb", png=b"a"), Picture(kind="depth", png=b"b")))
    blind = at_most([ASKED], ModelSettings(), KNOWN).input_tokens
    assert at_most([seen], ModelSettings(), KNOWN).input_tokens == blind + 2 * MOST_PER_PICTURE
    assert at_most([seen], ModelSettings(), replace(KNOWN, picture_tokens=765)).input_tokens == blind + 2 * 765


def png(width, height):
    """As much of a file as says how large a picture is."""
    return b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"and so on"


def picture_tokens(width, height, **facts):
    seen = replace(ASKED, pictures=(Picture(kind="rgb", png=png(width, height)),))
    facts = replace(KNOWN, **facts)
    return at_most([seen], ModelSettings(), facts).input_tokens - at_most([ASKED], ModelSettings(), facts).input_tokens


def tiled(width, height):
    """OpenAI's rule for gpt-4o: into 2048 by 2048, the shorter side to 768, 85 and 170 for every square of 512."""
    scale = min(1, 2048 / max(width, height))
    scale = min(scale, 768 / min(width, height))
    return 85 + 170 * math.ceil(scale * width / 512) * math.ceil(scale * height / 512)


def by_area(width, height):
    """Anthropic's rule without its scaling, and OpenAI's of patches without its bound."""
    return max(width * height / 750, math.ceil(width / 32) * math.ceil(height / 32))


@pytest.mark.parametrize("rule", [tiled, by_area])
@given(width=st.integers(64, 4096), height=st.integers(64, 4096))
def test_a_large_picture_counts_for_what_providers_take_at_most(rule, width, height):
    most = math.ceil(max(rule(side, 1024) for side in range(64, 1025, 64)))
    assert rule(width, height) <= picture_tokens(width, height, picture_tokens=most)


def test_every_block_of_a_picture_counts():
    assert picture_tokens(1024, 1024) == picture_tokens(64, 64) == MOST_PER_PICTURE
    assert picture_tokens(1025, 1024) == 2 * MOST_PER_PICTURE
    assert picture_tokens(4096, 4096) == 16 * MOST_PER_PICTURE
    assert picture_tokens(0, 0) == MOST_PER_PICTURE


def test_text_that_is_no_unicode_counts_too():
    assert at_most([replace(ASKED, text="\ud800")], ModelSettings(), KNOWN).input_tokens > 0


def test_the_share_that_is_repeated():
    one, two, three = [ASKED], [ASKED, REPLY, TOLD], [ASKED, REPLY, TOLD, REPLY, TOLD]
    sizes = [sum(len(message.text) for message in request) for request in (one, two, three)]
    assert repeated_prefix([one, two, three]) == pytest.approx((sizes[0] + sizes[1]) / sum(sizes))
    assert repeated_prefix([one]) == repeated_prefix([]) == 0
    assert repeated_prefix([one, one, one]) == pytest.approx(2 / 3)


def test_a_message_that_changes_ends_what_is_repeated():
    before, after = [ASKED, REPLY, TOLD], [ASKED, replace(REPLY, text='{"joint": "B"}'), TOLD]
    same = len(ASKED.text) + len('{"joint": "')
    assert repeated_prefix([before, after]) == pytest.approx(same / (2 * sum(len(m.text) for m in before)))
    assert repeated_prefix([[ASKED], [replace(ASKED, role="assistant")]]) == 0


def test_nearly_all_of_a_trial_is_repeated_with_repairs_and_with_pictures():
    for requests in (trial(20), trial(20, pictures=2), trial(20, repaired=True)):
        for before, after in itertools.pairwise(requests):
            shared = min(len(before), len(after)) - (2 if len(after) == len(before) else 0)
            assert after[:shared] == before[:shared]
        assert repeated_prefix(requests) > 0.85


def test_pictures_that_leave_the_conversation_break_the_prefix():
    whole, newest = trial(20, pictures=1), trial(20, pictures=1, images=4)
    assert repeated_prefix(newest, picture_tokens=765) < 0.5 < repeated_prefix(whole, picture_tokens=765)
