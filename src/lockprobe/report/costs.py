"""What an agent's trials cost: tokens as its provider counted them, times the prices that are known of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any

from pydantic import TypeAdapter

from lockprobe.agents.llm.model_facts import Price, facts_of
from lockprobe.report.rows import Estimate, Fact, Results
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Trial

__all__ = ["Prices", "cost_rows", "price_asked", "price_facts", "price_of", "prices_of"]


Prices = Mapping[str, Price | None]
"""Agent -> what its provider asks; None where that is not known."""


def cost_rows(trials: Sequence[Trial], place: Mapping[str, Any], prices: Prices | None = None) -> Iterator[Estimate]:
    """Replies, tokens and US dollars of one agent, and which models replied, as their provider names them.

    Replies that could not be used are among them. Where a provider did not count the tokens of a reply, its cost is not
    known and in no number here; such replies are counted as ``uncounted``. There is no cost where nothing was counted
    or no price is known, and none per solved trial where no trial was solved.

    Args:
        trials: The trials of one agent, those that broke among them.
        place: The columns of the rows that say of what they are.
        prices: The prices, where they are given instead of looked up.
    """
    found = [(trial, usage) for trial in trials for usage in _usages(trial)]
    counted = [(trial, usage) for trial, usage in found if usage.input_tokens or usage.output_tokens]
    calls, total = sum(usage.calls for _, usage in found), sum((usage for _, usage in counted), Usage())
    if found:
        yield Estimate(quantity="calls", **place, unit="calls", value=calls)
        yield Estimate(quantity="calls", **place, of="uncounted", unit="calls", value=calls - total.calls)
    if counted:
        for kind in ("input", "output", "reasoning"):
            yield Estimate(quantity="tokens", **place, of=kind, unit="tokens", value=getattr(total, f"{kind}_tokens"))
        if n := total.input_tokens:
            yield Estimate(
                quantity="cached_share", **place, value=total.cached_tokens / n, count=total.cached_tokens, n=n
            )
    if counted and (price := price_asked(trials, prices)):
        dollars = sum(price.of(usage, batch=bool(trial.facts.get("batch"))) for trial, usage in counted)
        yield Estimate(quantity="cost", **place, unit="US$", value=dollars)
        if solved := sum(trial.solved for trial in trials):
            yield Estimate(quantity="cost", **place, of="per solved trial", unit="US$", value=dollars / solved)
    served = Counter(step.decision.served for trial in trials for step in trial.steps if step.decision.served)
    for model, decisions in sorted(served.items()):
        yield Estimate(quantity="answers", **place, of=model, unit="decisions", value=decisions)


def price_asked(trials: Sequence[Trial], prices: Prices | None = None) -> Price | None:
    """What the provider of an agent asks; None where that is not known, or its trials name several models."""
    models = {str(trial.facts["model"]) for trial in trials if "model" in trial.facts}
    if len(models) != 1:
        return None
    agent = trials[0].group
    return facts_of(models.pop()).price if prices is None or agent not in prices else prices[agent]


def _usages(trial: Trial) -> list[Usage]:
    found = [step.decision.usage for step in trial.steps] + ([trial.error.usage] if trial.error else [])
    return [usage for usage in found if usage is not None]


def price_facts(agent: str, price: Price) -> Iterator[Fact]:
    """The prices that results hold of an agent; its numbers are read back exactly."""
    for name, value in asdict(price).items():
        if value is not None:
            yield Fact(about=_about(agent), name=name, text=value if isinstance(value, str) else repr(float(value)))


def price_of(found: Results, agent: str) -> Price | None:
    """The prices that results hold of an agent; None if they have none.

    Raises:
        ValueError: If they are no prices.
    """
    facts = found.facts_about(_about(agent))
    if not facts:
        return None
    known = {name: text if name in ("date", "source") else float(text) for name, text in facts.items()}
    return TypeAdapter(Price).validate_python(known)


def prices_of(found: Results) -> Prices:
    """The prices that results hold, None for agents without: what :func:`cost_rows` takes instead of looking them up.

    Agents whose prices cannot be read are left out, so that these are looked up.
    """
    prices = dict[str, Price | None]()
    for one in found.design.players:
        with suppress(ValueError):
            prices[one.agent] = price_of(found, one.agent)
    return prices


def _about(agent: str) -> str:
    return f"price of {agent}"
