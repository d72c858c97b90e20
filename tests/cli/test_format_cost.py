"""Money and tokens in words."""

from pathlib import Path

import pytest

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.cli.format_cost import about, estimate_lines, money, say_unlimited, spent_in_words
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import Spending
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.model_call import Usage

COST_PAGE = Path(__file__).parents[2] / "docs" / "cost.md"


@pytest.mark.parametrize(
    ("number", "said"),
    [(0, "0"), (7, "7"), (17.4, "17"), (950, "950"), (811, "810"), (1234, "1,200"), (58_400, "58,000"), (994_000, "990,000"),
     (999_600, "1 million"), (1_234_567, "1.23 million"), (123_456_789, "123 million")],
)  # fmt: skip
def test_tokens_are_read_to_two_or_three_digits(number, said):
    assert about(number) == said


def test_an_estimate_says_its_ranges_its_bound_and_the_date_of_its_prices():
    found = estimates(study(StudyOptions(agent=["llm:openai/gpt-4o"], full=True)), {})[0]
    first, second = estimate_lines(found)
    assert first.startswith("llm:openai/gpt-4o: about 3,600 to 4,200 calls, ")
    assert f"({found.repeated:.0%} of them sent before)" in first
    fresh, cached = (money(found.dollars(found.full, cached=hits)) for hits in (False, True))
    assert f" to {fresh} (" in second
    assert f" to {cached} with its provider's cache); at most {money(found.most_dollars)} whatever" in second
    assert second.endswith(f"; prices of {found.price.date}")
    quoted = COST_PAGE.read_text("utf-8").partition("```text\n")[2].splitlines()[:2]
    assert all(line.startswith(said.removesuffix("…")) for line, said in zip((first, second), quoted, strict=True))


def test_an_estimate_without_a_price_says_how_to_give_one():
    found = estimates(study(StudyOptions(agent=["llm:openai-api/some/model"], trials=1)), {})[0]
    assert estimate_lines(found)[1] == "  the price is not known (set it with LOCKPROBE_MODEL_FACTS=FILE.toml)"


def test_what_was_spent_is_money_where_it_is_known_and_tokens_elsewhere():
    usage = Usage(calls=2, input_tokens=1500, output_tokens=80)
    assert spent_in_words(Spending()) == ""
    assert spent_in_words(Spending(usage=usage, dollars=0.25)) == "$0.25 spent"
    assert spent_in_words(Spending(usage=usage)) == "1,500 tokens in, 80 out"
    told = spent_in_words(Spending(usage=usage, dollars=0.0, retries=1, failed=2, broken_off=1))
    assert told == "$0.00 spent, 1 retry, 2 calls failed, 1 call broken off"
    told = spent_in_words(Spending(usage=usage, dollars=0.086, dollars_unknown=0.027, broken_off=2))
    assert told == "$0.086 spent, 2 calls broken off; at most $0.027 more, uncounted"


def test_whom_a_budget_does_not_limit_is_said_on_the_stream_of_errors(tmp_path, monkeypatch, capsys):
    price = '{{ input = {0}, cached = {0}, output = {0}, date = "2026-11-27", source = "ours" }}'
    facts = [("free", 0), ("paid", 1)]
    (tmp_path / "own.toml").write_text(
        "".join(f'[[model]]\nmatch = ["vllm/{name}"]\nprice = {price.format(of)}\n' for name, of in facts)
    )
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "own.toml"))
    planned = study(StudyOptions(agent=["Ours=llm:vllm/free", "llm:vllm/paid", "random"]))
    say_unlimited(planned, 1)
    said = capsys.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)
    assert said.err.startswith("The budget does not limit Ours: the price is 0.")
    paid = study(StudyOptions(agent=["llm:vllm/paid"]))
    say_unlimited(paid, 1)
    say_unlimited(planned, None)
    assert capsys.readouterr().err == ""
