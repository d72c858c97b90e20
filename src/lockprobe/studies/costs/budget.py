"""The budget of a study: no call is made that could exceed it, and no trial is begun that it does not cover.

A call is covered by its upper bound, a trial by its estimate (:mod:`lockprobe.studies.costs.trial_costs`), played to
its last step. Estimates can be wrong, so money goes to the trials in the order in which they were opened: a later one
waits while earlier ones could need what is left. What is begun ends, if the budget allows it.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile

from lockprobe.agents.llm.model_facts import OWN_FACTS, Price, price_lines
from lockprobe.foundation.errors import BadValue, BudgetReached
from lockprobe.foundation.spec import Spec
from lockprobe.studies.costs.spending import hosted, most_dollars, price_of, unknown_dollars
from lockprobe.studies.costs.trial_costs import TrialCosts
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.plan import Plan


class Budget:
    """The budget of a study, including earlier runs. A call of unknown cost counts at its upper bound.

    ``allowed`` is in US dollars.

    Raises:
        BadValue: If the amount is not above 0, or the price of a model that would be called is not known.
    """

    def __init__(self, study: Study, allowed: float) -> None:
        if not 0 < allowed < float("inf"):
            raise BadValue("budget", allowed, "US dollars above 0")
        self.allowed = allowed
        self.spent = 0.0
        self._prices: dict[str, Price] = {}
        self._costs: dict[str, TrialCosts] = {}
        self._open: dict[str, TrialCosts] = {}
        """Trials that are being played, the first opened first."""
        self._reserved: dict[str, float] = {}
        self._lost: dict[str, float] = {}
        for agent in hosted(study):
            if (price := price_of(agent)) is None:
                raise _unpriced(agent, allowed)
            self._prices[agent] = price
            self._costs[agent] = TrialCosts(study, agent, price)

    @property
    def least(self) -> tuple[float, str]:
        """What has to be there to begin the cheapest trial, and its agent; 0 without a provider."""
        return min(((costs.least, agent) for agent, costs in self._costs.items()), default=(0.0, ""))

    def admit(self, plan: Plan) -> bool:
        """Open a trial, if what is left covers all open trials and this one; False if others have to end first.

        Raises:
            BudgetReached: If what is left does not cover it, and no trial is open.
        """
        if (costs := self._costs.get(plan.agent)) is None:
            return True
        costs.know(plan)
        needed = costs.rest(plan.key) + max(costs.last(plan.key), self._set_aside(self._open))
        if self._spent + self._rest(self._open) + needed > self.allowed:
            if not self._open:
                raise BudgetReached(self._spent, self.allowed, needed, of="trial")
            return False
        self._open[plan.key] = costs
        return True

    def end(self, key: str) -> None:
        """Close a trial: it has ended, or is left for another run."""
        self._open.pop(key, None)

    def has_turn(self, key: str, worst: Usage) -> bool:
        """Whether a trial may make its next call now: what is left then still covers the trials opened before it."""
        if (costs := self._open.get(key)) is None or key == next(iter(self._open)):
            return True
        before = list(takewhile(lambda one: one != key, self._open))
        next_call = costs.rest(key) - costs.rest(key, calls=1)
        aside = max(most_dollars(worst, costs.price), self._set_aside(before))
        return self._spent + self._rest(before) + next_call + aside <= self.allowed

    def reserve(self, call: Call) -> bool:
        """Reserve the maximum cost of a trial's next call; False if calls in flight have to return first.

        When a call is repeated, its earlier attempts count as spent at that cost each. A waiting call holds no
        reservation, so there is no deadlock.

        Raises:
            BudgetReached: If it does not fit even if calls in flight cost nothing.
        """
        if (price := self._prices.get(call.agent)) is None:
            return True
        most = most_dollars(call.most or Usage(), price)
        self._reserved.pop(call.key, None)
        self._lost[call.key] = call.unanswered * most
        if self._spent + most > self.allowed:
            raise BudgetReached(self._spent, self.allowed, most)
        if self._spent + sum(self._reserved.values()) + most > self.allowed:
            return False
        self._reserved[call.key] = most
        return True

    def settle(self, call: Call) -> None:
        """Replace a call's reservation by its cost."""
        self._reserved.pop(call.key, None)
        self._lost.pop(call.key, None)
        if (price := self._prices.get(call.agent)) is not None:
            self.spent += price.of(call.usage)
            self.spent += unknown_dollars(call, price)
            self._costs[call.agent].note(call)

    @property
    def _spent(self) -> float:
        """What is spent, including attempts of calls in flight that may have been charged for."""
        return self.spent + sum(self._lost.values())

    def _rest(self, keys: Iterable[str]) -> float:
        """What open trials are estimated to need."""
        return sum(self._open[key].rest(key) for key in keys)

    def _set_aside(self, keys: Iterable[str]) -> float:
        """What has to be left for the last call of any of these trials: its upper bound."""
        return max((self._open[key].last(key) for key in keys), default=0.0)

    def learn(self, call: Call) -> None:
        """Take the estimate from a call of another log, which this budget does not pay."""
        if (costs := self._costs.get(call.agent)) is not None:
            costs.note(call)


def _unpriced(agent: str, allowed: float) -> BadValue:
    """The refusal of a budget for a model of unknown price, with the lines that make it known."""
    expected = (
        f"no budget with {agent}, whose price is not known; put these lines with its price into a file of your own "
        f"and set {OWN_FACTS}=FILE.toml:"
    )
    refusal = BadValue("budget", f"{allowed:g}", expected)
    refusal.to_copy = price_lines(Spec.parse(agent).name)
    return refusal
