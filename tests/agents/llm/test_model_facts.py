"""What is known of models is data that is checked, one's own before what is shipped."""

from datetime import date
from fnmatch import fnmatchcase

import pytest

from lockprobe.agents.llm.model_facts import (
    OWN_FACTS,
    SHIPPED,
    ModelFacts,
    Price,
    facts_of,
    price_lines,
    price_of,
    read_facts,
)
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.trial.model_call import Usage

PRICE = '{ input = 2.0, cached = 0.5, output = 8.0, date = "2026-01-02", source = "a list" }'


@pytest.fixture(autouse=True)
def nothing_of_ones_own(monkeypatch):
    monkeypatch.delenv(OWN_FACTS, raising=False)


def written(path, text):
    path.write_text(text)
    return path


def test_of_an_unknown_model_nothing_is_known():
    assert facts_of("vllm/somebody/something-7b") == ModelFacts()
    assert facts_of("openai-api/mine/model").price is None


@pytest.mark.parametrize("name", ["openai/o1", "openai/o1-2024-12-17", "openai/o3-mini", "openai/o4-mini"])
def test_reasoning_models_fix_their_sampling_and_take_an_effort(name):
    facts = facts_of(name)
    assert (facts.sampling, facts.reasons) == ("fixed", True)
    assert facts.efforts == ("low", "medium", "high")


def test_names_that_begin_alike_are_told_apart():
    assert facts_of("openai/gpt-4o").price.input > 10 * facts_of("openai/gpt-4o-mini").price.input
    assert facts_of("openai/gpt-4o-2024-11-20") == facts_of("openai/gpt-4o")
    assert facts_of("openai/gpt-5.1").sampling != facts_of("openai/gpt-5").sampling
    assert not facts_of("openai/gpt-4o-audio-preview").known
    assert facts_of("anthropic/claude-opus-5-5").price != facts_of("anthropic/claude-opus-5").price


def test_some_models_cannot_see():
    assert facts_of("openai/o3-mini").images is False
    assert facts_of("openai/gpt-4o").images is True
    assert facts_of("ollama/llava").images is None


def test_no_pattern_of_the_shipped_file_is_shadowed_by_an_earlier_one():
    seen = []
    for entry in read_facts(SHIPPED):
        for pattern in entry.match:
            examples = [pattern.replace("*", tail) for tail in ("", "-2026-01-01", "x")]
            assert not any(all(fnmatchcase(name, before) for name in examples) for before in seen), pattern
        seen += entry.match
    assert len(seen) == len(set(seen))


def test_every_shipped_price_says_where_it_is_from_and_when():
    prices = [entry.says["price"] for entry in read_facts(SHIPPED) if "price" in entry.says]
    assert len(prices) > 15
    for price in prices:
        assert date.fromisoformat(price.date) > date(2025, 1, 1)
        assert price.cached <= price.input <= (price.stored or price.input)
        assert price.source


def test_what_is_shipped_hangs_together():
    for entry in read_facts(SHIPPED):
        facts = ModelFacts(**entry.says)
        assert facts.most_output is None or facts.context is None or facts.most_output <= facts.context
        assert facts.images or (facts.largest_image, facts.picture_tokens) == (None, None)


def test_a_price_counts_every_token_once():
    price = Price(input=2, cached=0.5, output=8, stored=2.5, date="2026-01-02", source="a list")
    usage = Usage(calls=1, input_tokens=1_000_000, output_tokens=250_000, cached_tokens=400_000, stored_tokens=100_000)
    assert price.of(usage) == pytest.approx(0.5 * 2 + 0.4 * 0.5 + 0.1 * 2.5 + 0.25 * 8)
    plain = Price(input=2, cached=0.5, output=8, date="2026-01-02", source="a list")
    assert plain.of(usage) == pytest.approx(0.6 * 2 + 0.4 * 0.5 + 0.25 * 8)


def test_a_file_of_ones_own_adds_models_and_goes_before_what_is_shipped(tmp_path, monkeypatch):
    text = f'[[model]]\nmatch = ["openai/gpt-4o", "openai-api/mine/*"]\nprice = {PRICE}\n'
    shipped = facts_of("openai/gpt-4o")
    monkeypatch.setenv(OWN_FACTS, str(written(tmp_path / "mine.toml", text)))
    own = Price(input=2, cached=0.5, output=8, date="2026-01-02", source="a list")
    assert facts_of("openai-api/mine/model") == ModelFacts(price=own)
    changed = facts_of("openai/gpt-4o")
    assert changed.price == own
    assert (changed.context, changed.images) == (shipped.context, shipped.images)
    assert facts_of("openai/gpt-4o-mini").price.source != "a list"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[[model", "not TOML"),
        ("[[modle]]\nmatch = ['a']", r"modle: expected only tables \[\[model\]\]"),
        ("model = 3", r"model: expected only tables \[\[model\]\]"),
        ("model = [3]", "model 1: expected a table"),
        ("[[model]]\nimages = true", "model 1: match: "),
        ("[[model]]\nmatch = ['a*b*c*d*e*f*g*']", "model 1: match"),
        (
            "[[model]]\nmatch = ['a']\n[[model]]\nmatch = ['b']\nimage = true",
            r"model 2 \(b\): image: .*; keys are match,",
        ),
        ("[[model]]\nmatch = ['a']\nknown = true", r"model 1 \(a\): known: .*; keys are match,"),
        ("[[model]]\nmatch = ['a']\nefforts = ['huge']", r"model 1 \(a\): efforts.0: expected 'none',"),
        ("[[model]]\nmatch = ['a']\ncontext = -1", r"model 1 \(a\): context: expected "),
        ("[[model]]\nmatch = ['a']\nprice = { input = 1.0 }", r"model 1 \(a\): price.cached: "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('2.0', '-2.0')}", r"model 1 \(a\): price.input: "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('2.0', 'inf')}", r"model 1 \(a\): price.input: "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('2026-01-02', 'today')}", r"model 1 \(a\): price.date: "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('01-02', '13-41')}", r"model 1 \(a\): price.date: "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('2.0', 'true')}", r"model 1 \(a\): price.input: "),
        ("[[model]]\nmatch = ['a']\nimages = 'yes'", r"model 1 \(a\): images: "),
        ("[[model]]\nmatch = ['[!a]*']", "model 1: match"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_line_with_the_key(tmp_path, monkeypatch, text, why):
    path = written(tmp_path / "mine.toml", text)
    monkeypatch.setenv(OWN_FACTS, str(path))
    with pytest.raises(BadFile, match=f"^{path}: {why}") as wrong:
        facts_of("openai/gpt-4o")
    assert "\n" not in str(wrong.value)


@pytest.mark.parametrize("fact", ["images = false", "most_output = 900", "context = 8192", 'schema = "strict"'])
def test_a_fact_of_ones_own_says_nothing_of_the_others(tmp_path, monkeypatch, fact):
    before = ModelSettings().sent(facts_of("vllm/qwen"))
    monkeypatch.setenv(OWN_FACTS, str(written(tmp_path / "own.toml", f"[[model]]\nmatch = ['vllm/*']\n{fact}\n")))
    facts = facts_of("vllm/qwen")
    assert (facts.known, facts.sampling, facts.efforts, facts.reasons) == (True, None, None, None)
    assert ModelSettings().sent(facts) == before
    assert ModelSettings().parameters(facts) == {}
    ModelSettings(temperature=0.5, top_p=0.5, effort="low", max_tokens=900, schema="strict").check("vllm/qwen", facts)


def test_whether_a_model_reasons_bounds_its_replies_and_the_efforts_it_takes_are_what_is_not_refused(
    tmp_path, monkeypatch
):
    text = "[[model]]\nmatch = ['vllm/*']\nreasons = false\nefforts = []\n"
    monkeypatch.setenv(OWN_FACTS, str(written(tmp_path / "own.toml", text)))
    facts = facts_of("vllm/qwen")
    assert ModelSettings().sent(facts).items() >= {"effort": "not taken", "max_tokens": 1000}.items()
    with pytest.raises(BadValue, match="effort: got 'low', expected no effort with vllm/qwen"):
        ModelSettings(effort="low").check("vllm/qwen", facts)


def test_a_file_that_is_not_there_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "none.toml"))
    with pytest.raises(BadFile, match=r"none.toml: cannot be read \(No such file or directory\)"):
        facts_of("openai/gpt-4o")


def test_a_price_of_ones_own_changes_nothing_that_is_asked(tmp_path, monkeypatch):
    before = ModelSettings().sent(facts_of("openai-api/mine/model"))
    path = tmp_path / "own.toml"
    path.write_text(f'[[model]]\nmatch = ["openai-api/mine/*"]\nprice = {PRICE}\n')
    monkeypatch.setenv(OWN_FACTS, str(path))
    facts = facts_of("openai-api/mine/model")
    assert facts.price.output == 8.0
    assert ModelSettings().sent(facts) == before
    path.with_name("more.toml").write_text(
        f'[[model]]\nmatch = ["openai-api/mine/*"]\nreasons = false\nprice = {PRICE}\n'
    )
    monkeypatch.setenv(OWN_FACTS, str(path.with_name("more.toml")))
    assert ModelSettings().sent(facts_of("openai-api/mine/model")) != before


def test_a_price_that_no_file_has_is_the_one_of_the_package_and_routers_have_none(tmp_path, monkeypatch):
    known = price_of("openai/gpt-4.1-mini")
    assert known.date.startswith("genai-prices ")
    assert 0 < known.cached < known.input == known.stored < known.output
    assert price_of("openai/gpt-4o").date == facts_of("openai/gpt-4o").price.date
    for name in ("openai/never-heard-of", "openrouter/openai/gpt-4o", "openai-api/openai/gpt-4o", "vllm/gpt-4o"):
        assert price_of(name) is None
    (tmp_path / "own.toml").write_text("\n".join(price_lines("openai/gpt-4.1-mini")))
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "own.toml"))
    assert price_of("openai/gpt-4.1-mini").source == "made up"
