"""Formats money, tokens, errors and the estimated cost of a study."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Mapping
from dataclasses import asdict, fields
from math import floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

from lockprobe.agents.llm.model_facts import OWN_FACTS, price_lines
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.spending import Spending
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import STORE, OnRecord, read
from lockprobe.studies.study import Study

if TYPE_CHECKING:
    from lockprobe.studies.costs.estimate import Estimate


def money(dollars: float) -> str:
    """US dollars to the cent; amounts below ten cents to two digits.

    >>> [money(amount) for amount in (1234.5, 0.0144, 0.000077)]
    ['$1,234.50', '$0.014', '$0.000077']
    """
    if dollars >= 0.1 or dollars <= 0:
        return f"${dollars:,.2f}"
    said = f"{dollars:.{1 - floor(log10(dollars))}f}"
    return f"${said[:4]}{said[4:].rstrip('0')}"


def about(number: float) -> str:
    """A number to two or three digits: 950, 3,400, 1.23 million."""
    if number >= 995_000:
        return f"{number / 1e6:.3g} million"
    return f"{round(number, 2 - len(str(round(number)))):,.0f}"


def estimate_lines(found: Estimate) -> list[str]:
    """The estimated cost of an agent's trials, in words."""

    def span(low: str, high: str) -> str:
        return low if low == high else f"{low} to {high}"

    calls, tokens_in, tokens_out = (
        span(about(getattr(found.low, name)), about(getattr(found.high, name)))
        for name in ("calls", "input_tokens", "output_tokens")
    )
    trials = f"{'at most ' * found.until}{count(found.trials, 'trial')}"
    lines = [f"{found.called}: {trials}, about {calls} calls, {tokens_in} tokens in, {tokens_out} out"]
    if (paid := found.dollars()) is None or found.price is None:
        return [*lines, f"  the price is not known (set it with {OWN_FACTS}=FILE.toml)"]
    return [*lines, f"  about {span(*map(money, paid))}; prices of {found.price.date}"]


def settings_line(found: str) -> str:
    """The hash of the settings, as it is said before the first trial."""
    return f"Settings: {found} (for a preregistration; lockprobe verify DIR --settings HASH checks it)"


def print_estimates(study: Study, directory: Path, *, json: bool) -> None:
    """Print the estimated cost of all trials that a study owes, without touching its directory."""
    done = dict[str, OnRecord]()
    if is_there(directory / STORE):
        with read(directory) as store:
            done = on_record(store, read_study(directory))
    from lockprobe.studies.costs.estimate import estimates  # a trial's loop, which what was spent needs not

    found = estimates(study, done)
    if json:
        print(json_.dumps({"estimate": [one.facts() for one in found]}))
        return
    print(settings_line(study.settings_hash), file=sys.stderr)
    for one in found:
        print("\n".join(estimate_lines(one)))
        if one.price is None:
            print("\n".join(map(printable, price_lines(Spec.parse(one.agent).name))))
    if not found:
        print("No cost: no trial that asks a provider is owed.")


def in_boundaries(errors: Mapping[str, int]) -> str:
    """Errors by boundary: ``3 errors: model 2, reply 1``; empty where there are none."""
    named = ", ".join(f"{name} {errors[name]}" for name in sorted(errors))
    return f"{count(sum(errors.values()), 'error')}: {named}" if errors else ""


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
    """The cost of calls, for JSON: every number of it and of its usage by its name, and of the price its date."""
    found = {one.name: getattr(spent, one.name) for one in fields(spent) if one.name not in ("usage", "price")}
    return asdict(spent.usage) | found | {"price_date": spent.price and spent.price.date}
