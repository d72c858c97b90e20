"""The budget of a study: no call is made that could exceed it.

A call is covered by its upper bound, which is reserved on disk before it is sent and replaced by its cost afterwards. A
trial that is refused a call stops there, and resumes from it with a larger budget.
"""

from __future__ import annotations

from lockprobe.agents.llm.model_facts import OWN_FACTS, Price, price_lines
from lockprobe.foundation.errors import BadValue, BudgetReached
from lockprobe.foundation.spec import Spec
from lockprobe.studies.costs.spending import hosted, most_dollars, price_of, unknown_dollars
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call, Usage


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
        self._reserved: dict[str, float] = {}
        self._lost: dict[str, float] = {}
        for agent in hosted(study):
            if (price := price_of(agent)) is None:
                copied = f"put these lines with its price into a file of your own and set {OWN_FACTS}=FILE.toml:"
                expected = f"no budget with {agent}, whose price is not known; {copied}"
                refusal = BadValue("budget", f"{allowed:g}", expected)
                refusal.to_copy = price_lines(Spec.parse(agent).name)
                raise refusal
            self._prices[agent] = price

    def reserve(self, call: Call) -> bool:
        """Reserve the maximum cost of a trial's next call; False if calls in flight have to return first.

        When a call is repeated, its earlier attempts count as spent: as counted, or at that cost each. A waiting call
        holds no reservation, so there is no deadlock.

        Raises:
            BudgetReached: If it does not fit even if calls in flight cost nothing.
        """
        if (price := self._prices.get(call.agent)) is None:
            return True
        most = most_dollars(call.most or Usage(), price)
        self._reserved.pop(call.key, None)
        self._lost[call.key] = call.unanswered * most + price.of(call.usage)
        spent = self.spent + sum(self._lost.values())  # with attempts in flight that may have been charged for
        if spent + most > self.allowed:
            raise BudgetReached(spent, self.allowed, most)
        if spent + sum(self._reserved.values()) + most > self.allowed:
            return False
        self._reserved[call.key] = most
        return True

    def settle(self, call: Call) -> None:
        """Replace a call's reservation by its cost."""
        self._reserved.pop(call.key, None)
        self._lost.pop(call.key, None)
        if (price := self._prices.get(call.agent)) is not None:
            self.spent += price.of(call.usage) + unknown_dollars(call, price)
