"""Money and tokens in words."""

from pathlib import Path

import pytest

from lockprobe.cli.format_cost import about, estimate_lines, money, spent_in_words
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import Spending
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.model_call import Usage

COST_PAGE = Path(__file__).parents[2] / "docs" / "cost.md"


@pytest.mark.parametrize(
    ("say", "number", "said"),
    [
        (about, 0, "0"), (about, 17.4, "17"), (about, 811, "810"), (about, 58_400, "58,000"), (about, 999_600, "1 million"),
        (about, 1_234_567, "1.23 million"), (money, 0, "$0.00"), (money, 0.1, "$0.10"), (money, 1234.5, "$1,234.50"),
        (money, 0.0144, "$0.014"), (money, 0.00001, "$0.00001"), (money, 0.0996, "$0.10"),
    ],
)  # fmt: skip
def test_numbers_are_read_to_two_or_three_digits_and_money_to_the_cent(say, number, said):
    assert say(number) == said


def test_an_estimate_says_its_range_and_the_date_of_its_prices_as_the_docs_do():
    quoted = COST_PAGE.read_text("utf-8").split("```text\n")[1].partition("```")[0]
    lines = estimate_lines(estimates(study("flips", agent="llm:openai/gpt-4o", full=True), {})[0])
    for said, line in zip(lines, quoted.splitlines(), strict=False):
        assert said.startswith(line.removesuffix("…"))
    (first, second) = estimate_lines(estimates(study("flips", agent="llm:openai-api/some/model", trials=1), {})[0])
    assert first.startswith("llm:openai-api/some/model: about ")
    assert second == "  the price is not known (set it with LOCKPROBE_MODEL_FACTS=FILE.toml)"


def test_what_was_spent_is_money_where_it_is_known_and_tokens_elsewhere():
    usage = Usage(calls=2, input_tokens=1500, output_tokens=80)
    assert spent_in_words(Spending()) == ""
    assert spent_in_words(Spending(usage=usage)) == "1,500 tokens in, 80 out"
    told = spent_in_words(
        Spending(usage=usage, dollars=0.086, dollars_unknown=0.027, retries=1, failed=2, broken_off=1)
    )
    assert told == "$0.086 spent, 1 retry, 2 calls failed, 1 call broken off; at most $0.027 more, uncounted"
