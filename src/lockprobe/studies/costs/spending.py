"""The cost of a study by agent.

Money is in US dollars: tokens times the known prices of a model (:mod:`lockprobe.agents.llm.model_facts`). If a price
is not known, the cost is None, never 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from math import floor, log10
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm import model_facts
from lockprobe.agents.llm.model_facts import Price
from lockprobe.foundation.spec import Spec
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call, Usage


@dataclass(frozen=True, slots=True, kw_only=True)
class Spending:
    """The cost of an agent's calls.

    Attributes:
        usage: Tokens counted by the providers; ``usage.calls`` is the number of calls with a reply.
        failed: Calls without a reply from the provider.
        broken_off: Calls in flight when their run ended.
        uncounted: Replies without a token count.
        unanswered: Attempts that may have been charged without a usable reply; see :class:`Call`.
        repeated_tokens: Input tokens in the common prefix with the request before, which a cache could have kept. None
            if pictures leave the conversation, because token counts then do not show it.
        retries: Number of retries.
        seconds: Total duration of the calls; parallel calls are added up.
        dollars: Cost; None if the price is not known.
        dollars_unknown: Upper bound of the additional cost of calls without a count; None as above.
        served: Models that answered, by the providers' names, and how often.
        claimed: Calls with an impossible token count; they are charged at their upper bound.
        claimed_dollars: Their cost by the provider's count; None as above.
        price: The price used; None if it is not known, or if there were several.
    """

    usage: Usage = field(default_factory=Usage)
    failed: int = 0
    broken_off: int = 0
    uncounted: int = 0
    unanswered: int = 0
    repeated_tokens: int | None = 0
    retries: int = 0
    seconds: float = 0.0
    dollars: float | None = None
    dollars_unknown: float | None = None
    served: tuple[tuple[str, int], ...] = ()
    claimed: int = 0
    claimed_dollars: float | None = None
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
        self._pictured = study.has_pictures
        self._sums = {agent: _AgentSpending(agent, pictured=self._pictured) for agent in study.agents}
        for call in calls:
            self.add(call)

    def add(self, call: Call) -> None:
        """Add a call."""
        if call.owed_anew:
            return
        if call.agent not in self._sums:
            self._sums[call.agent] = _AgentSpending(call.agent, pictured=self._pictured)
        self._sums[call.agent].add(call)

    @property
    def by_agent(self) -> dict[str, Spending]:
        """Spending by agent, in the order of the study; agents without calls are left out."""
        found = {agent: counted.spending for agent, counted in self._sums.items()}
        return {agent: spent for agent, spent in found.items() if spent.usage.calls or spent.failed or spent.broken_off}

    @property
    def total(self) -> Spending:
        """Total spending; the cost is None if one agent's cost is not known."""
        return total(list(self.by_agent.values()))


def total(parts: Sequence[Spending]) -> Spending:
    """The sum of every field; None if any part is None."""
    if not parts:
        return Spending()

    def added(name: str) -> Any:
        values = [getattr(part, name) for part in parts]
        return None if None in values else sum(values[1:], values[0])

    served: Counter[str] = Counter()
    for part in parts:
        served.update(dict(part.served))
    price = parts[0].price if len({part.price for part in parts}) == 1 else None
    return Spending(**{name: added(name) for name in _SUMMED}, served=tuple(served.most_common()), price=price)


_SUMMED = [one.name for one in fields(Spending) if one.name not in ("served", "price")]


class _AgentSpending:
    """Adds up the calls of one agent."""

    def __init__(self, agent: str, *, pictured: bool) -> None:
        price = price_of(agent)
        nothing = None if price is None else 0.0
        # pictures are dropped from the middle of its conversations then, so that requests share no prefix
        drops_pictures = Spec.parse(agent).options.get("images", "0") != "0"
        self._sum = Spending(
            repeated_tokens=None if pictured and drops_pictures else 0,
            dollars=nothing,
            dollars_unknown=nothing,
            claimed_dollars=nothing,
            price=price,
        )
        self._served: Counter[str] = Counter()
        self._read: dict[str, dict[int, int]] = {}

    @property
    def spending(self) -> Spending:
        return replace(self._sum, served=tuple(self._served.most_common()))

    def add(self, call: Call) -> None:
        replied, price = call.reply is not None, self._sum.price
        spent = Spending(
            usage=replace(call.usage, calls=max(1, call.usage.calls) if replied else 0),
            failed=not replied and not call.broken_off,
            broken_off=call.broken_off,
            uncounted=call.uncounted,
            unanswered=call.unanswered,
            repeated_tokens=self._repeated(call) if replied else 0,
            retries=call.retries,
            seconds=call.seconds,
            dollars=None if price is None else price.of(call.usage),
            dollars_unknown=None if price is None else unknown_dollars(call, price),
            claimed=call.claimed is not None,
            claimed_dollars=None if price is None else price.of(call.claimed or Usage()),
            price=price,
        )
        self._sum = total([self._sum, spent])
        if replied and call.served:
            self._served[call.served] += 1

    def _repeated(self, call: Call) -> int:
        """Tokens of the common prefix: a request extends the one before, or the first of the step before."""
        read, count = self._read.setdefault(call.key, {}), call.usage.input_tokens
        repeated = min(read.get(call.step - 1 if call.turn == 1 else 0, 0), count)
        if call.turn == 1:
            self._read[call.key] = {call.step: count, 0: count}
        else:
            read[0] = count
        return repeated


def dollars(amount: float) -> str:
    """Format US dollars to the cent, below ten cents to two significant digits, without the dollar sign.

    >>> [dollars(amount) for amount in (1234.5, 0.0144, 0.000077)]
    ['1,234.50', '0.014', '0.000077']
    """
    if amount >= 0.1 or amount <= 0:
        return f"{amount:,.2f}"
    said = f"{amount:.{1 - floor(log10(amount))}f}"
    return said[:4] + said[4:].rstrip("0")
