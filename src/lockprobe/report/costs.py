"""What an agent's trials cost: tokens as its provider counted them, times the prices that are known of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass

from pydantic import TypeAdapter

from lockprobe.agents.llm.model_facts import Price, facts_of
from lockprobe.model_call import Usage
from lockprobe.record import Trial
from lockprobe.rows import Fact, Results

__all__ = ["Money", "Prices", "money", "price_facts", "price_of", "prices_of"]


Prices = Mapping[str, Price | None]
"""Agent -> what its provider asks; None where that is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Money:
    """What the trials of one agent cost.

    Attributes:
        calls: Replies that came, those that could not be used among them; None of an agent that calls no model.
        usage: Of those whose tokens the provider counted; None where there is none.
        uncounted: Replies of decisions without a count of tokens: what they cost is not known, and in no number here.
        dollars: US dollars for what was counted; None where nothing was, or no price is known.
        per_solved: The same for each solved trial; None where no price is known, or no trial was solved.
        price: The prices used; None where none is known.
        served: Models that answered, as the provider names them, with the decisions of each.
    """

    calls: int | None
    usage: Usage | None
    uncounted: int
    dollars: float | None
    per_solved: float | None
    price: Price | None
    served: tuple[tuple[str, int], ...]


def money(trials: Sequence[Trial], prices: Prices | None = None) -> Money:
    """Add up the trials of one agent, those that broke among them.

    Args:
        trials: Their facts name the model, if there is one.
        prices: The prices, where they are given instead of looked up.
    """
    decisions = [step.decision for trial in trials for step in trial.steps]
    found = [(trial, usage) for trial in trials for usage in _usages(trial)]
    counted = [(trial, usage) for trial, usage in found if usage.input_tokens or usage.output_tokens]
    calls = sum(usage.calls for _, usage in found)
    total = sum((usage for _, usage in counted), Usage())
    served = Counter(decision.served for decision in decisions if decision.served)
    models = {str(trial.facts["model"]) for trial in trials if "model" in trial.facts}
    price = _price(trials[0].group, models.pop(), prices) if len(models) == 1 else None
    dollars = (
        sum(price.of(usage, batch=bool(trial.facts.get("batch"))) for trial, usage in counted)
        if price and counted
        else None
    )
    solved = sum(trial.solved for trial in trials)
    return Money(
        calls=calls if found else None,
        usage=total if counted else None,
        uncounted=calls - total.calls,
        dollars=dollars,
        per_solved=dollars / solved if dollars is not None and solved else None,
        price=price,
        served=tuple(sorted(served.items())),
    )


def _price(agent: str, model: str, prices: Prices | None) -> Price | None:
    return facts_of(model).price if prices is None or agent not in prices else prices[agent]


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
    """The prices that results hold, None for agents without: what :func:`money` takes instead of looking them up.

    Agents whose prices cannot be read are left out, so that these are looked up.
    """
    prices = dict[str, Price | None]()
    for one in found.design.players:
        with suppress(ValueError):
            prices[one.agent] = price_of(found, one.agent)
    return prices


def _about(agent: str) -> str:
    return f"price of {agent}"
