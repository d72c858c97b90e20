"""The cost of a study by agent.

Money is in US dollars: tokens times the known prices of a model (:mod:`lockprobe.agents.llm.model_facts`). If a price
is not known, the cost is None, never 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import reduce
from operator import add
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm import model_facts
from lockprobe.agents.llm.model_facts import Price
from lockprobe.foundation.spec import Spec
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call, Usage


@dataclass(frozen=True, slots=True, kw_only=True)
class Spending:
    """The cost of calls.

    Attributes:
        usage: Tokens counted by the providers; ``usage.calls`` is the number of calls with a reply.
        failed: Calls without a reply from the provider.
        broken_off: Calls in flight when their run ended.
        unpriced: Attempts whose cost nobody said: broken off, without a count, or without a usable reply.
        retries: Number of retries.
        claimed: Calls with an impossible token count; they are charged at their upper bound.
        seconds: Total duration of the calls; parallel calls are added up.
        dollars: Cost; None if the price is not known.
        dollars_unknown: Upper bound of what ``unpriced`` attempts cost besides; None as above.
        served: Models that answered, by the providers' names, and how often.
        price: The price used; None if it is not known, or if there were several.
    """

    usage: Usage = field(default_factory=Usage)
    failed: int = 0
    broken_off: int = 0
    unpriced: int = 0
    retries: int = 0
    claimed: int = 0
    seconds: float = 0.0
    dollars: float | None = None
    dollars_unknown: float | None = None
    served: Counter[str] = field(default_factory=Counter)
    price: Price | None = None


def hosted(study: Study) -> tuple[str, ...]:
    """The hosted agents of a study, which call a provider."""
    return tuple(spec for spec in study.agents if resolve(spec).engine == "network")


def price_of(agent: str) -> Price | None:
    """The price of an agent's provider; None if it is not known, or there is no provider."""
    spec = Spec.parse(agent)
    return model_facts.price_of(spec.name) if spec.kind == "llm" else None


def most_dollars(usage: Usage, price: Price) -> float:
    """Upper bound of the cost of a usage, US dollars, whatever the cache does."""
    dearest = max(price.input, price.cached, price.stored or 0.0)
    return (usage.input_tokens * dearest + usage.output_tokens * price.output) / 1e6


def unknown_dollars(call: Call, price: Price) -> float:
    """Upper bound of the cost of a call's attempts without a reported usage, US dollars."""
    return call.unpriced * most_dollars(call.most or Usage(), price)


class Ledger:
    """The ledger of a study: adds up the cost of its calls."""

    def __init__(self, study: Study, calls: Iterable[Call] = ()) -> None:
        self._sums = dict[str, Spending]()
        self._order = study.agents
        for call in calls:
            self.add(call)

    def add(self, call: Call) -> None:
        """Add a call."""
        if call.owed_anew:
            return
        replied, before = call.reply is not None, self._sums.get(call.agent)
        price = before.price if before else price_of(call.agent)
        spent = Spending(
            usage=replace(call.usage, calls=max(1, call.usage.calls) if replied else 0),
            failed=int(not replied and not call.broken_off),
            broken_off=int(call.broken_off),
            unpriced=call.unpriced,
            retries=call.retries,
            claimed=int(call.claimed is not None),
            seconds=call.seconds,
            dollars=None if price is None else price.of(call.usage),
            dollars_unknown=None if price is None else unknown_dollars(call, price),
            served=Counter([call.served] if replied and call.served else []),
            price=price,
        )
        self._sums[call.agent] = total([before, spent] if before else [spent])

    @property
    def by_agent(self) -> dict[str, Spending]:
        """Spending by agent, in the order of the study; agents without calls are left out."""
        return {agent: self._sums[agent] for agent in dict.fromkeys((*self._order, *self._sums)) if agent in self._sums}

    @property
    def total(self) -> Spending:
        """Total spending; the cost is None if one agent's cost is not known."""
        return total([*self._sums.values()])


def total(parts: Sequence[Spending]) -> Spending:
    """The sum of every field; None if any part is None."""
    if not parts:
        return Spending()
    found = dict[str, Any]()
    for name in (one.name for one in fields(Spending) if one.name != "price"):
        values = [getattr(part, name) for part in parts]
        found[name] = None if None in values else reduce(add, values)
    return Spending(**found, price=parts[0].price if len({part.price for part in parts}) == 1 else None)
