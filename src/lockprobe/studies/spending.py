"""What a study has cost, and a budget that it cannot pass.

Money is US dollars, tokens times the prices that are known of a model (:mod:`lockprobe.agents.llm.model_facts`). Where
a price is not known the money is not known either: it is None, never 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.model_facts import OWN_FACTS, Price, facts_of
from lockprobe.call import Call, Usage
from lockprobe.errors import BadValue, BudgetReached
from lockprobe.spec import Spec
from lockprobe.studies.study import Study
from lockprobe.studies.trial_keys import Owners

__all__ = ["Budget", "Ledger", "Spending", "hosted", "most_dollars", "price_of"]


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
        dollars_unknown: What calls that nobody counted can have cost beside that, at most; None as above.
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
    """What a study has cost, call by call.

    Args:
        study: The study.
        calls: The calls to begin with, those that were never answered as broken off.
    """

    def __init__(self, study: Study, calls: Iterable[Call] = ()) -> None:
        self._owners, self._pictured = Owners(study), study.has_pictures
        self._sums = {agent: _Sum(agent, pictured=self._pictured) for agent in study.agents}
        for call in calls:
            self.add(call)

    def add(self, call: Call) -> None:
        """One more call."""
        if call.owed_anew:
            return
        agent = self._owners.of(call.key)
        if agent not in self._sums:
            self._sums[agent] = _Sum(agent, pictured=self._pictured)
        self._sums[agent].add(call)

    @property
    def by_agent(self) -> dict[str, Spending]:
        """By agent, in the order in which they stand in the study; those that asked nobody are left out."""
        return {agent: counted.spending for agent, counted in self._sums.items() if counted.any}

    @property
    def total(self) -> Spending:
        """All together; the money is None as soon as one agent's is not known."""
        return _total(list(self.by_agent.values()))


def _total(parts: Sequence[Spending]) -> Spending:
    served: Counter[str] = Counter()
    for part in parts:
        served.update(dict(part.served))
    known = [part.dollars for part in parts if part.dollars is not None]
    unknown = [part.dollars_unknown for part in parts if part.dollars_unknown is not None]
    claims = [part.claimed_dollars for part in parts if part.claimed_dollars is not None]
    repeated = [part.repeated_tokens for part in parts if part.repeated_tokens is not None]
    return Spending(
        usage=sum((part.usage for part in parts), Usage()),
        failed=sum(part.failed for part in parts),
        broken_off=sum(part.broken_off for part in parts),
        uncounted=sum(part.uncounted for part in parts),
        unanswered=sum(part.unanswered for part in parts),
        repeated_tokens=sum(repeated) if len(repeated) == len(parts) else None,
        retries=sum(part.retries for part in parts),
        seconds=sum(part.seconds for part in parts),
        dollars=sum(known) if parts and len(known) == len(parts) else None,
        dollars_unknown=sum(unknown) if parts and len(unknown) == len(parts) else None,
        served=tuple(served.most_common()),
        claimed=sum(part.claimed for part in parts),
        claimed_dollars=sum(claims) if parts and len(claims) == len(parts) else None,
        price=parts[0].price if len({part.price for part in parts}) == 1 else None,
    )


class _Sum:
    """Adds calls of one agent up."""

    def __init__(self, agent: str, *, pictured: bool) -> None:
        self.price = price_of(agent)
        self._prefixes = not (pictured and _drops_pictures(agent))
        self.usage = Usage()
        self.failed = self.broken_off = self.uncounted = self.unanswered = self.retries = self.repeated = 0
        self._before: dict[str, dict[int, int]] = {}
        self.seconds = self.dollars = self.unknown = self.claims = 0.0
        self.claimed = 0
        self.served: Counter[str] = Counter()

    @property
    def any(self) -> bool:
        return bool(self.usage.calls or self.failed or self.broken_off)

    def add(self, call: Call) -> None:
        replied = call.reply is not None
        self.usage += replace(call.usage, calls=max(1, call.usage.calls) if replied else 0)
        self.broken_off += call.broken_off
        self.failed += not replied and not call.broken_off
        self.uncounted += call.uncounted
        self.unanswered += call.unanswered
        self.retries += call.retries
        self.seconds += call.seconds
        self.claimed += call.claimed is not None
        if replied:
            self._repeated(call)
            self.served.update([call.served] if call.served else [])
        if self.price is not None:
            self.dollars += self.price.of(call.usage, batch=call.batch)
            self.unknown += _unknown_dollars(call, self.price)
            self.claims += self.price.of(call.claimed, batch=call.batch) if call.claimed is not None else 0.0

    def _repeated(self, call: Call) -> None:
        """A request extends the one before in its step, or the first of the step before; repairs are not kept."""
        read = self._before.setdefault(call.key, {})
        if call.turn == 1:
            self.repeated += min(read.get(call.step - 1, 0), call.usage.input_tokens)
            self._before[call.key] = {call.step: call.usage.input_tokens, 0: call.usage.input_tokens}
        else:
            self.repeated += min(read.get(0, 0), call.usage.input_tokens)
            read[0] = call.usage.input_tokens

    @property
    def spending(self) -> Spending:
        return Spending(
            usage=self.usage,
            failed=self.failed,
            broken_off=self.broken_off,
            uncounted=self.uncounted,
            unanswered=self.unanswered,
            repeated_tokens=self.repeated if self._prefixes else None,
            retries=self.retries,
            seconds=self.seconds,
            dollars=None if self.price is None else self.dollars,
            dollars_unknown=None if self.price is None else self.unknown,
            served=tuple(self.served.most_common()),
            claimed=self.claimed,
            claimed_dollars=None if self.price is None else self.claims,
            price=self.price,
        )


def _drops_pictures(agent: str) -> bool:
    """Whether pictures leave an agent's conversations from their middle, so that requests do not grow at their ends."""
    return Spec.parse(agent).options.get("images", "0") != "0"


class Budget:
    """An amount that a study may spend, earlier runs included. A call whose cost nobody knows counts as its worst case.

    Args:
        study: The study.
        allowed: US dollars, above 0.

    Raises:
        BadValue: If there is nothing to spend, or no price is known of a model that would be asked.
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
        """Set aside what the next call of a trial can cost; False where calls on their way have to come back first.

        Where a call is made again, what it took so far counts as spent, and one that waits has nothing set aside: so
        calls never wait for each other.

        Args:
            key: The trial.
            worst: What one attempt can cost at most.
            unanswered: Attempts of the same call that may have been charged for.

        Raises:
            BudgetReached: If it does not fit even if those cost nothing. From then on nothing fits.
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
