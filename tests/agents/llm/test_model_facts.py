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
from lockprobe.agents.llm.settings import Model
from lockprobe.foundation.errors import BadFile
from lockprobe.studies.costs.spending import most_dollars
from lockprobe.trial.model_call import Usage

PRICE = '{ input = 2.0, cached = 0.5, output = 8.0, date = "2026-01-02", source = "a list" }'
OWN = Price(input=2, cached=0.5, output=8, date="2026-01-02", source="a list")


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Writes a file of facts of one's own."""

    def write(text):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.toml"
        path.write_text(text)
        monkeypatch.setenv(OWN_FACTS, str(path))
        return path

    return write


def test_what_is_shipped_hangs_together():
    """No pattern is shadowed by an earlier one, and every price says where it is from and when."""
    seen = []
    for entry in read_facts(SHIPPED):
        for pattern in entry.match:
            examples = [pattern.replace("*", tail) for tail in ("", "-2026-01-01", "x")]
            assert not any(all(fnmatchcase(name, before) for name in examples) for before in seen), pattern
        seen += entry.match
        assert entry.images or entry.picture_tokens is None
        price = price_of(entry.match[0].replace("*", ""))
        assert price.date.startswith("genai-prices") or date.fromisoformat(price.date) > date(2025, 1, 1)
        assert price.cached <= price.input <= (price.stored or price.input)
        assert price.source
    assert len(seen) == len(set(seen)) > 15


def test_a_price_counts_every_token_once_and_those_of_a_cache_as_others_where_they_have_none_of_their_own(own):
    price = Price(input=2, cached=0.5, output=8, stored=2.5, date="2026-01-02", source="a list")
    usage = Usage(calls=1, input_tokens=1_000_000, output_tokens=250_000, cached_tokens=400_000, stored_tokens=100_000)
    assert price.of(usage) == pytest.approx(0.5 * 2 + 0.4 * 0.5 + 0.1 * 2.5 + 0.25 * 8)
    assert OWN.of(usage) == pytest.approx(0.6 * 2 + 0.4 * 0.5 + 0.25 * 8)
    own("[[model]]\nmatch = ['a/b']\nprice = { input = 3.0, output = 2.0, date = 'd', source = 's' }")
    assert price_of("a/b").of(usage) == most_dollars(usage, price_of("a/b")) == pytest.approx(3 + 0.25 * 2)


def test_a_file_of_ones_own_adds_models_and_goes_before_what_is_shipped_and_a_price_changes_no_request(own):
    shipped, before = facts_of("openai/gpt-4o"), Model.parse("openai-api/mine/model").sent()
    entry = f'[[model]]\nmatch = ["openai/gpt-4o", "openai-api/mine/*"]\nprice = {PRICE}\n'
    own(entry)
    assert facts_of("openai-api/mine/model") == ModelFacts(price=OWN)
    assert Model.parse("openai-api/mine/model").sent() == before
    changed = facts_of("openai/gpt-4o")
    assert (changed.price, changed.most_output, changed.images) == (OWN, shipped.most_output, shipped.images)
    assert price_of("openai/gpt-4o-mini") != OWN
    own(f"{entry}reasons = false\n")
    assert Model.parse("openai-api/mine/model").sent() == before | {"max_tokens": 1000}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[[model", "not TOML"),
        ("[[modle]]\nmatch = ['a']", r"modle \[key\]: expected .model."),
        ("model = [3]", "model 1: "),
        ("[[model]]\nimages = true", "model 1 match: "),
        ("[[model]]\nmatch = ['a']\n[[model]]\nmatch = ['b']\nimage = true", "model 2 image: .*keys are reasons, .*, match"),
        ("[[model]]\nmatch = ['a']\nmost_output = -1", "model 1 most_output: expected "),
        ("[[model]]\nmatch = ['a']\nprice = { in = 1.0, output = 2.0, date = 'd', source = 's' }",
         r"model 1 price in: no such key \(keys are input, cached, "),
        (f"[[model]]\nmatch = ['a']\nprice = {PRICE.replace('2.0', 'inf')}", "model 1 price input: "),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_used_is_one_line_with_the_key(own, text, why):
    path = own(text)
    with pytest.raises(BadFile, match=f"^{path}: {why}") as wrong:
        facts_of("openai/gpt-4o")
    assert "\n" not in str(wrong.value)


def test_a_price_that_no_file_has_is_the_one_of_the_package_and_routers_have_none(own):
    assert price_of("openai/gpt-4o").input < price_of("openai/gpt-4o-2024-05-13").input
    known = price_of("openai/gpt-4.1-mini")
    assert known.date.startswith("genai-prices ")
    assert 0 < known.cached < known.input == known.stored < known.output
    for name in ("openai/never-heard-of", "openrouter/openai/gpt-4o", "openai-api/openai/gpt-4o", "vllm/gpt-4o"):
        assert price_of(name) is None
    own("\n".join(price_lines("openai/gpt-4.1-mini")))
    assert price_of("openai/gpt-4.1-mini").source == "made up"
