"""Exact probabilities of allowed answers, bit-identical whatever was played before."""

import math

import pytest

from lockprobe.agents import weights
from lockprobe.agents.engine import Engine
from lockprobe.foundation.errors import BadFile, BadValue

PREFIX = "A lockbox has several joints. The target joint is: B."


@pytest.fixture(scope="module")
def engine():
    return Engine(weights.locate("llm:local"))


def tokens(engine, *texts):
    return [engine.tokens(text) for text in texts]


def full_softmax(engine, prompt):
    """Log-probabilities of the whole vocabulary after a prompt."""
    answer = engine._server.handle_completions(
        {"prompt": prompt, "n_predict": 1, "temperature": 1.0, "n_probs": 49152, "cache_prompt": False}
    )
    top = answer["choices"][0]["logprobs"]["content"][0]["top_logprobs"]
    return {entry["id"]: entry["logprob"] for entry in top}


def test_a_score_is_the_softmax_over_the_allowed_answers(engine):
    options = tokens(engine, " A", " B", " C", " D")
    assert all(len(option) == 1 for option in options)
    prompt = [*engine.restart(PREFIX), *engine.tokens(" The next joint is:")]
    whole = full_softmax(engine, prompt)
    masses = [math.exp(whole[option[0]]) for option in options]
    expected = [mass / sum(masses) for mass in masses]
    engine.restart(PREFIX + " ")
    engine.restart(PREFIX)
    assert engine.score(prompt, options) == pytest.approx(expected, abs=2e-3)
    assert max(expected) - min(expected) > 0.02  # the model does prefer some


def test_answers_of_several_tokens_multiply_along_their_paths(engine):
    options = tokens(engine, " slider one", " slider two", " lever")
    assert len(options[0]) > 1
    prompt = [*engine.restart(PREFIX), *engine.tokens(" The next joint is the")]
    scored = engine.score(prompt, options)
    assert sum(scored) == pytest.approx(1)
    slider = engine.score(prompt, [options[0][:1], options[2]])[0]
    one = engine.score([*prompt, options[0][0]], [options[0][1:], options[1][1:]])[0]
    assert scored[0] == pytest.approx(slider * one, abs=0.02)


def test_one_answer_is_certain_and_none_may_begin_with_another(engine):
    assert engine.score([1, 2], [(3,)]) == [1.0]
    with pytest.raises(BadValue, match="^options: "):
        engine.score([1, 2], [(3,), (3, 4)])


def test_scores_do_not_depend_on_what_was_asked_before_and_nothing_is_printed(engine, capfd):
    options = tokens(engine, " A", " B", " C")

    def asked(text):
        return engine.score([*engine.restart(PREFIX), *engine.tokens(text)], options)

    texts = [" The joints are: A, B, C. Next joint:", " The joints are: A, C, B. Next joint:", " Next one is joint"]
    first = [asked(text) for text in texts]
    assert [asked(text) for text in reversed(texts)] == first[::-1]
    other = Engine(weights.locate("llm:local"))
    assert other.score([*other.restart(PREFIX), *other.tokens(texts[2])], options) == first[2]
    assert capfd.readouterr() == ("", "")


def test_it_says_what_it_is(engine):
    facts = engine.facts()
    assert facts["quantisation"] == "Q4_1"
    assert facts["parameters"] == 134515008
    assert facts["runtime"].startswith("xllamacpp ")


def test_a_file_that_only_looks_like_a_model(tmp_path, capfd):
    (tmp_path / "bad.gguf").write_bytes(b"GGUF" + bytes(100))
    with pytest.raises(BadFile, match=r"bad.gguf: cannot be loaded by xllamacpp"):
        Engine(tmp_path / "bad.gguf")


def test_weights_that_give_no_probabilities_are_named(tmp_path):
    """Infinite weights, which make every probability none at all."""
    content = weights.locate("llm:local").read_bytes()
    (tmp_path / "bad.gguf").write_bytes(content[:-2000] + 1000 * b"\x00\x7c")
    damaged = Engine(tmp_path / "bad.gguf", context=256)
    with pytest.raises(BadFile, match="bad.gguf: its weights give no probabilities"):
        damaged.restart(PREFIX)
