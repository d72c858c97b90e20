"""The cost of a study by agent, and its budget: no call is made that could exceed it.

Money is in US dollars: tokens times the known prices of a model (:mod:`lockprobe.agents.llm.model_facts`). If a price
is not known, the cost is None, never 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import add
from typing import Any, Self

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.model_facts import Price, price_of
from lockprobe.foundation.errors import BadValue, BudgetReached
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

    @classmethod
    def of(cls, call: Call, price: Price | None) -> Self:
        """The cost of one call."""
        replied = call.reply is not None
        return cls(
            usage=call.usage if replied and call.usage.calls else replace(call.usage, calls=int(replied)),
            failed=int(not replied and not call.broken_off),
            broken_off=int(call.broken_off),
            unpriced=call.unpriced,
            retries=call.retries,
            claimed=int(call.claimed is not None),
            seconds=call.seconds,
            dollars=None if price is None else price.of(call.usage),
            dollars_unknown=None if price is None else call.unpriced * most_dollars(call.most, price),
            served=Counter([call.served] if replied and call.served else []),
            price=price,
        )

    @property
    def most(self) -> float:
        """What it can have cost at most, US dollars, as a budget counts it; 0 if the price is not known."""
        return (self.dollars or 0.0) + (self.dollars_unknown or 0.0)

    def __add__(self, other: Spending) -> Spending:
        """Both together; what is None in one of them is None."""
        both = {name: (getattr(self, name), getattr(other, name)) for name in Spending.__slots__ if name != "price"}
        found: dict[str, Any] = {name: None if None in pair else add(*pair) for name, pair in both.items()}
        return Spending(**found, price=self.price if self.price == other.price else None)


def total(parts: Iterable[Spending]) -> Spending:
    """The sum of all, nothing if there are none; the cost is None if that of one is not known."""
    return reduce(add, found) if (found := list(parts)) else Spending()


def hosted(study: Study) -> tuple[str, ...]:
    """The hosted agents of a study, which call a provider."""
    return tuple(spec for spec in study.agents if resolve(spec).engine == "network")


def agent_price(agent: str) -> Price | None:
    """The price of an agent's provider; None if it is not known, or there is no provider."""
    spec = Spec.parse(agent)
    return price_of(spec.name) if spec.kind == "llm" else None


def most_dollars(usage: Usage | None, price: Price) -> float:
    """Upper bound of the cost of a usage, US dollars, whatever the cache does."""
    used, dearest = usage or Usage(), max(price.input, price.cached or 0.0, price.stored or 0.0)
    return (used.input_tokens * dearest + used.output_tokens * price.output) / 1e6


def spent_by_agent(calls: Iterable[Call], before: Mapping[str, Spending] | None = None) -> dict[str, Spending]:
    """Agent -> the cost of its calls, in the order of their first ones; with what was spent ``before``."""
    found = dict(before or {})
    for call in calls:
        there = found.get(call.agent)
        spent = Spending.of(call, there.price if there else agent_price(call.agent))
        found[call.agent] = there + spent if there else spent
    return found


class Budget:
    """The budget of a directory in US dollars, earlier runs included. A call of unknown cost counts at its upper bound.

    A call is covered by its upper bound, which is reserved on disk before it is sent and replaced by its cost
    afterwards. A trial that is refused a call stops there, and resumes from it with a larger budget.

    Raises:
        BadValue: If the amount is not above 0, or the price of a model that would be called is not known.
    """

    def __init__(self, study: Study, allowed: float) -> None:
        if not 0 < allowed < float("inf"):
            raise BadValue("budget", allowed, "US dollars above 0")
        self.allowed = allowed
        self._prices: dict[str, Price] = {}
        self._reserved: dict[str, float] = {}
        self._lost: dict[str, float] = {}
        for agent in hosted(study):
            if (price := agent_price(agent)) is None:
                expected = f"none with {agent}, whose price is not known; --estimate prints what gives it one"
                raise BadValue("budget", f"{allowed:g}", expected)
            self._prices[agent] = price

    def reserve(self, call: Call, spent: float) -> bool:
        """Reserve the maximum cost of a trial's next call; False if calls in flight have to return first.

        ``spent`` are US dollars of calls with an outcome. When a call is repeated, its earlier attempts count too: as
        counted, or at that cost each. A waiting call holds no reservation, so there is no deadlock.

        Raises:
            BudgetReached: If it does not fit even if calls in flight cost nothing.
        """
        if (price := self._prices.get(call.agent)) is None:
            return True
        most = most_dollars(call.most, price)
        self._reserved.pop(call.key, None)
        self._lost[call.key] = call.unanswered * most + price.of(call.usage)
        spent += sum(self._lost.values())  # with attempts in flight that may have been charged for
        if spent + most > self.allowed:
            raise BudgetReached(spent, self.allowed, most)
        if spent + sum(self._reserved.values()) + most > self.allowed:
            return False
        self._reserved[call.key] = most
        return True

    def release(self, call: Call) -> None:
        """A call has an outcome: what was reserved for it is no more, since its cost is known."""
        self._reserved.pop(call.key, None)
        self._lost.pop(call.key, None)
