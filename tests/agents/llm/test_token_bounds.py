"""How large a request is: never larger than was said."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Model, ModelSettings
from lockprobe.agents.llm.token_bounds import MOST_OUTPUT, MOST_PER_PICTURE, at_most, tokens
from lockprobe.agents.prompt import Message, conversation, example, reply_schema
from lockprobe.trial.pictures.picture import Picture

ASKED = Message(role="user", text="What now?")
REPLY = Message(role="assistant", text='{"joint": "A"}')
TOLD = Message(role="user", text="A did not move.")


def most(*messages, max_tokens=None, **facts):
    model = Model(name="a/b", settings=ModelSettings(max_tokens=max_tokens), facts=ModelFacts(**facts))
    return at_most(messages, model)


def test_no_call_takes_more_than_was_said():
    """Tokens of a byte-level tokenizer are at most the bytes; the local model's own count stands beside it."""
    engine = pytest.importorskip("lockprobe.agents.engine")
    weights = pytest.importorskip("lockprobe.agents.weights")
    if weights.embedded() is None:
        pytest.skip("the embedded model is not installed")
    counts = engine.Engine(weights.locate("llm:local"), context=256)
    texts = [*(message.text for message in conversation(example())), "}{][,,;;" * 20, "Verklemmt 🔒 锁住了 " * 20]
    for text in texts:
        said = most(Message(role="user", text=text)).input_tokens
        assert len(counts.tokens(text)) + len(counts.tokens(str(reply_schema(example())))) <= said
    ours = "".join(texts[:3])
    assert len(counts.tokens(ours)) == pytest.approx(tokens(ours), rel=0.3)
    assert most(replace(ASKED, text="\ud800")).input_tokens > 0


def test_what_a_reply_may_take_is_what_is_asked_for():
    assert most(ASKED, max_tokens=55).output_tokens == 55
    assert most(ASKED, reasons=False).output_tokens == 1000
    assert most(ASKED, reasons=True).output_tokens == 25_000
    assert most(ASKED).output_tokens == MOST_OUTPUT
    assert most(ASKED, most_output=900).output_tokens == 900


def picture_tokens(width, height, shown=1, **facts):
    """Of a picture of which as much is there as says how large it is."""
    png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"and so on"
    seen = replace(ASKED, pictures=(Picture(kind="rgb", png=png),) * shown)
    return most(seen, **facts).input_tokens - most(ASKED, **facts).input_tokens


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
def test_a_picture_counts_for_what_providers_take_at_most(rule, width, height):
    largest = math.ceil(max(rule(side, 1024) for side in range(64, 1025, 64)))
    assert rule(width, height) <= picture_tokens(width, height, picture_tokens=largest)


def test_every_block_of_every_picture_counts():
    assert picture_tokens(1024, 1024) == picture_tokens(64, 64) == picture_tokens(0, 0) == MOST_PER_PICTURE
    assert picture_tokens(1025, 1024) == picture_tokens(64, 64, shown=2) == 2 * MOST_PER_PICTURE
    assert picture_tokens(4096, 4096, picture_tokens=765) == 16 * 765
    bare = replace(ASKED, pictures=(Picture(kind="rgb", png=b"a"),))
    assert most(bare).input_tokens == most(ASKED).input_tokens + MOST_PER_PICTURE
