"""Formats money, tokens and the estimated cost of a study."""

from __future__ import annotations

import json as json_
import sys
from dataclasses import asdict
from pathlib import Path

from lockprobe.agents.llm.model_facts import OWN_FACTS, price_lines
from lockprobe.foundation.formatting import count, listed
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import Estimate, estimates
from lockprobe.studies.costs.spending import Spending, hosted, most_dollars, price_of
from lockprobe.studies.costs.spending import dollars as in_words
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.records.trial_rows import OnRecord
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Usage


def money(dollars: float) -> str:
    """US dollars to the cent; amounts below ten cents to two digits."""
    return f"${in_words(dollars)}"


def about(number: float) -> str:
    """A number to two or three digits: 950, 3,400, 1.23 million."""
    if number >= 999_500:
        return f"{number / 1e6:.3g} million"
    return f"{round(number, 2 - len(str(round(number)))):,.0f}"


def _span(low: float, high: float) -> str:
    """Two numbers as a range, or as one number if they look the same."""
    first, last = about(low), about(high)
    if first == last:
        return first
    if first.endswith("million") and last.endswith("million"):
        first = first.removesuffix(" million")
    return f"{first} to {last}"


def _paid(low: float | None, high: float | None) -> str:
    if low is None or high is None:
        return "an unknown price"
    return money(low) if money(low) == money(high) else f"{money(low)} to {money(high)}"


def share(part: float | None, whole: float) -> float | None:
    """A share; None if the whole is zero or the part is not known."""
    return part / whole if whole and part is not None else None


def estimate_lines(found: Estimate) -> list[str]:
    """The estimated cost of an agent's trials, in words."""
    low, high = found.expected, found.full
    until = ""
    if found.until:
        goal = "decided" if found.until == "decided" else f"{found.until} points"
        until = f"until {goal}, at most {found.trials:,} trials, which take "
    first = (
        f"{found.called}: {until}about {_span(low.calls, high.calls)} calls, "
        f"{_span(low.input_tokens, high.input_tokens)} tokens in ({found.repeated:.0%} of them sent before), "
        f"{_span(low.output_tokens, high.output_tokens)} out"
    )
    if found.most_dollars is None:
        return [first, f"  the price is not known (set it with {OWN_FACTS}=FILE.toml)"]
    fresh, cached = (_paid(*(found.dollars(one, cached=hits) for one in (low, high))) for hits in (False, True))
    kept = "" if cached == fresh else f" ({cached} with its provider's cache)"
    date = "price not known" if found.price is None else f"prices of {found.price.date}"
    paid = f"  about {fresh}{kept}; at most {money(found.most_dollars)} whatever it replies; {date}"
    return [first, paid, *([_LESS] if found.until else [])]


_LESS = "  a smaller --budget is fine: what is decided when it ends holds, and a larger one goes on from there"


def estimate_facts(found: Estimate) -> dict[str, object]:
    """The estimated cost of an agent's trials, for JSON."""

    def one(usage: Usage) -> dict[str, object]:
        return {
            "calls": usage.calls,
            "input_tokens": usage.input_tokens,
            "output_tokens": usage.output_tokens,
            "dollars": found.dollars(usage, cached=False),
            "dollars_cached": found.dollars(usage, cached=True),
        }

    return {
        "agent": found.called,
        "trials": found.trials,
        "rests_on": found.rests_on,
        "expected": one(found.expected),
        "full": one(found.full),
        "most": {
            "calls": found.most.calls,
            "input_tokens": found.most.input_tokens,
            "output_tokens": found.most.output_tokens,
            "dollars": found.most_dollars,
        },
        "repeated_prefix_share": round(found.repeated, 4),
        "price": None if found.price is None else asdict(found.price),
        **({"until": found.until} if found.until else {}),
    }


def print_estimates(study: Study, directory: Path, *, json: bool) -> None:
    """Print the estimated cost of all trials that a study owes, without touching its directory."""
    done = dict[str, OnRecord]()
    if is_there(directory / STORE):
        with read(directory) as store:
            done, _ = on_record(store, study)
    found = estimates(study, done, read_calls(directory))
    if json:
        print(json_.dumps({"estimate": [estimate_facts(one) for one in found]}))
    elif not hosted(study):
        print("No cost: no agent of this study asks a provider.")
    elif not found:
        print("No cost: no trial that asks a provider is owed.")
    for one in found if not json else ():
        print("\n".join(estimate_lines(one)))
        if one.price is None:
            print("\n".join(map(printable, price_lines(Spec.parse(one.agent).name))))


def say_unlimited(study: Study, budget: float | None) -> None:
    """Say whom a budget does not limit, on the stream of errors; nothing where it limits all."""
    one = Usage(input_tokens=1, output_tokens=1)
    prices = {agent: price_of(agent) for agent in hosted(study)}
    free = [agent for agent, price in prices.items() if price is not None and most_dollars(one, price) == 0]
    if budget is not None and free:
        whom = listed([study.label_of(agent) for agent in free])
        said = f"The budget does not limit {whom}: the price is 0. At 1, a dollar is a million tokens"
        print(printable(said), file=sys.stderr)


def spent_in_words(spent: Spending) -> str:
    """The cost of calls, in a few words, and what calls of unknown cost can have cost; empty without calls."""
    if not (spent.usage.calls or spent.failed or spent.broken_off):
        return ""
    tokens = f"{about(spent.usage.input_tokens)} tokens in, {about(spent.usage.output_tokens)} out"
    said = [tokens if spent.dollars is None else f"{money(spent.dollars)} spent"]
    for number, one, several in (
        (spent.retries, "retry", "retries"),
        (spent.failed, "call failed", "calls failed"),
        (spent.broken_off, "call broken off", "calls broken off"),
    ):
        said += [count(number, one, several)] if number else []
    unknown = f"; at most {money(spent.dollars_unknown)} more, uncounted" if spent.dollars_unknown else ""
    return ", ".join(said) + unknown


def spent_facts(spent: Spending) -> dict[str, object]:
    """The cost of calls, for JSON."""
    usage = spent.usage
    return {
        "calls": usage.calls,
        "failed_calls": spent.failed,
        "broken_off_calls": spent.broken_off,
        "uncounted_calls": spent.uncounted,
        "unanswered_attempts": spent.unanswered,
        "retries": spent.retries,
        "input_tokens": usage.input_tokens,
        "cached_tokens": usage.cached_tokens,
        "output_tokens": usage.output_tokens,
        "reasoning_tokens": usage.reasoning_tokens,
        "cached_share": share(usage.cached_tokens, usage.input_tokens),
        "repeated_prefix_share": share(spent.repeated_tokens, usage.input_tokens),
        "dollars": spent.dollars,
        "dollars_unknown": spent.dollars_unknown,
        "claimed_calls": spent.claimed,
        "claimed_dollars": spent.claimed_dollars,
        "price_date": None if spent.price is None else spent.price.date,
        "served": dict(spent.served),
        "seconds_of_calls": round(spent.seconds, 1),
    }
