"""What a study has cost, by agent, and the budget that it cannot exceed.

Money is US dollars, tokens times the prices that are known of a model (:mod:`lockprobe.agents.llm.model_facts`). Where
a price is not known the money is not known either: it is None, never 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from math import floor, log10
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.model_facts import OWN_FACTS, Price, facts_of
from lockprobe.errors import BadValue, BudgetReached
from lockprobe.interventions.condition import MODALITIES
from lockprobe.model_call import Call, Usage
from lockprobe.spec import Spec, spec_name
from lockprobe.studies.study import Study

__all__ = ["Budget", "Ledger", "Owners", "Spending", "dollars", "hosted", "most_dollars", "price_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spending:
    """What an agent's calls have cost.

    Attributes:
        usage: What its providers counted; ``usage.calls`` got a reply.
        failed: Calls to which the provider gave no reply.
        broken_off: Calls that were on their way when their run ended.
        uncounted: Replies that came without a count of tokens.
        unanswered: Attempts that may have been charged for, though nothing of use came back; see :class:`Call`.
        repeated_tokens: Of the tokens read, those that the request before had begun with: what a cache could have kept.
            None where pictures leave the conversation, so that counts of tokens do not say it.
        retries: How often a provider had to be asked again.
        seconds: Time that calls took, side by side ones added up.
        dollars: What that cost; None where the price is not known.
        dollars_unknown: What calls without a count can have cost in addition, at most; None as above.
        served: Models that answered, as providers name them, and how often.
        claimed: Calls for which a provider counted far more than they can have cost; they count as the most they can.
        claimed_dollars: What it would have cost by that count; None as above.
        price: The price that was used; None where it is not known, or several were.
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
    """The agents of a study that ask a provider."""
    return tuple(spec for spec in study.agents if resolve(spec).engine == "network")


def price_of(agent: str) -> Price | None:
    """What an agent's provider asks; None where that is not known, or there is no provider."""
    spec = Spec.parse(agent)
    return facts_of(spec.name).price if spec.kind == "llm" else None


def most_dollars(usage: Usage, price: Price) -> float:
    """What a usage can cost at most, in US dollars, wherever its tokens come from and go to."""
    dearest = max(price.input, price.cached, price.stored or 0.0)
    return (usage.input_tokens * dearest + usage.output_tokens * price.output) / 1e6


def _unknown_dollars(call: Call, price: Price) -> float:
    """What those attempts of a call can have cost at most whose cost nobody said."""
    return call.unpriced * most_dollars(call.most or Usage(), price)


class Ledger:
    """What a study has cost, call by call."""

    def __init__(self, study: Study, calls: Iterable[Call] = ()) -> None:
        self._owners, self._pictured = Owners(study), study.has_pictures
        self._sums = {agent: _AgentSpending(agent, pictured=self._pictured) for agent in study.agents}
        for call in calls:
            self.add(call)

    def add(self, call: Call) -> None:
        """One more call."""
        if call.owed_anew:
            return
        agent = self._owners.of(call.key)
        if agent not in self._sums:
            self._sums[agent] = _AgentSpending(agent, pictured=self._pictured)
        self._sums[agent].add(call)

    @property
    def by_agent(self) -> dict[str, Spending]:
        """By agent, in the order in which they stand in the study; those that asked nobody are left out."""
        found = {agent: counted.spending for agent, counted in self._sums.items()}
        return {agent: spent for agent, spent in found.items() if spent.usage.calls or spent.failed or spent.broken_off}

    @property
    def total(self) -> Spending:
        """All together; the money is None as soon as one agent's is not known."""
        return _total(list(self.by_agent.values()))


def _total(parts: Sequence[Spending]) -> Spending:
    """The sum of every field. What one part does not know, the sum does not know either."""
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
        self._sum = Spending(
            repeated_tokens=None if pictured and _drops_pictures(agent) else 0,
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
            dollars=None if price is None else price.of(call.usage, batch=call.batch),
            dollars_unknown=None if price is None else _unknown_dollars(call, price),
            claimed=call.claimed is not None,
            claimed_dollars=None if price is None else price.of(call.claimed or Usage(), batch=call.batch),
            price=price,
        )
        self._sum = _total([self._sum, spent])
        if replied and call.served:
            self._served[call.served] += 1

    def _repeated(self, call: Call) -> int:
        """A request extends the one before in its step, or the first of the step before; repairs are not kept."""
        read, count = self._read.setdefault(call.key, {}), call.usage.input_tokens
        repeated = min(read.get(call.step - 1 if call.turn == 1 else 0, 0), count)
        if call.turn == 1:
            self._read[call.key] = {call.step: count, 0: count}
        else:
            read[0] = count
        return repeated


def _drops_pictures(agent: str) -> bool:
    """Whether pictures leave an agent's conversations from their middle, so that requests do not grow at their ends."""
    return Spec.parse(agent).options.get("images", "0") != "0"


class Budget:
    """An amount that a study may spend, earlier runs included. A call of unknown cost counts as its worst case.

    ``allowed`` is in US dollars.

    Raises:
        BadValue: If the amount is not above 0, or no price is known of a model that would be asked.
    """

    def __init__(self, study: Study, allowed: float) -> None:
        if not 0 < allowed < float("inf"):
            raise BadValue("budget", allowed, "US dollars above 0")
        self.allowed = allowed
        self.spent = 0.0
        self._owners = Owners(study)
        self._prices: dict[str, Price] = {}
        self._reserved: dict[str, float] = {}
        self._lost: dict[str, float] = {}
        self._reached: BudgetReached | None = None
        for agent in hosted(study):
            if (price := price_of(agent)) is None:
                raise BadValue(
                    "budget",
                    f"{allowed:g}",
                    f"no budget with {agent}, whose price is not known; "
                    f"write it into a file of your own and set {OWN_FACTS}=FILE.toml",
                )
            self._prices[agent] = price

    def reserve(self, key: str, worst: Usage, unanswered: int = 0) -> bool:
        """Set aside the maximum cost of a trial's next call; False where calls on their way have to come back first.

        When a call is repeated, its earlier attempts count as spent at ``worst`` each. A waiting call has nothing set
        aside, so calls never wait for each other.

        Raises:
            BudgetReached: If it does not fit even if those on their way cost nothing. From then on nothing fits.
        """
        if self._reached is not None:
            raise self._reached
        if (price := self._price(key)) is None:
            return True
        most = most_dollars(worst, price)
        self._reserved.pop(key, None)
        self._lost[key] = unanswered * most
        spent = self.spent + sum(self._lost.values())
        if spent + most > self.allowed:
            self._reached = BudgetReached(spent, self.allowed, most)
            raise self._reached
        if spent + sum(self._reserved.values()) + most > self.allowed:
            return False
        self._reserved[key] = most
        return True

    def settle(self, call: Call) -> None:
        """Put what a call cost in place of what was set aside for it."""
        self._reserved.pop(call.key, None)
        self._lost.pop(call.key, None)
        if (price := self._price(call.key)) is not None:
            self.spent += price.of(call.usage, batch=call.batch)
            self.spent += _unknown_dollars(call, price)

    def _price(self, key: str) -> Price | None:
        return self._prices.get(self._owners.of(key))


class Owners:
    """Whose trial a key names."""

    def __init__(self, study: Study) -> None:
        self._study = f"{study.name}/"
        self._of_flips = study.of_flips
        self._shows = study.names_modalities
        shown = [f"/{modality}" for modality in study.modalities] if self._shows else [""]
        self._agents = {f"{spec}{how}": spec for spec in study.agents for how in shown}

    def of(self, key: str) -> str:
        """The agent. Specs hold slashes; one of another study counts as what stands in its place."""
        if not self._of_flips:
            return key.removeprefix(self._study).rpartition("/rep=")[0].rpartition("/")[0] or key
        named = key.removeprefix(self._study).rpartition("/p=")[0]
        if named in self._agents:
            return self._agents[named]
        agent, _, how = named.rpartition("/")
        return (agent if self._shows and spec_name(how) in MODALITIES else named) or key


def dollars(amount: float) -> str:
    """US dollars to the cent, less than ten cents to two digits; without their sign.

    >>> [dollars(amount) for amount in (1234.5, 0.0144, 0.000077)]
    ['1,234.50', '0.014', '0.000077']
    """
    if amount >= 0.1 or amount <= 0:
        return f"{amount:,.2f}"
    said = f"{amount:.{1 - floor(log10(amount))}f}"
    return said[:4] + said[4:].rstrip("0")
