"""What is left to pay of a trial if it is played to its last step, estimated anew with every reply."""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate

from lockprobe.agents.llm.model_facts import Price, facts_of
from lockprobe.agents.llm.settings import read_settings
from lockprobe.studies.costs.estimate import assumed_output
from lockprobe.studies.costs.request_sizes import PromptSizes
from lockprobe.studies.costs.spending import most_dollars
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.plan import Plan


class TrialCosts:
    """The costs of one agent's trials, in US dollars.

    Requests are predicted by the plan of a trial. What providers charge for them, and the length of replies, is taken
    from the calls so far (:meth:`note`). Without calls both are assumed as in :mod:`lockprobe.studies.costs.estimate`.

    Attributes:
        price: The price of the agent's model.
    """

    def __init__(self, study: Study, agent: str, price: Price) -> None:
        name, self._settings = read_settings(agent)
        self._facts, self.price = facts_of(name), price
        self._plans = {plan.key: plan for plan in study.plans(agent)}
        self._conditions: dict[str, _ConditionCosts] = {}
        self._replies: dict[str, int] = {}
        self._counted = self._first = 0
        self._paid_in = self._paid_out = self._predicted = 0.0

    @property
    def least(self) -> float:
        """What has to be there to begin a trial of the cheapest condition."""
        first = {plan.condition.label: key for key, plan in reversed(self._plans.items())}
        return min(self.rest(key) + self.last(key) for key in first.values())

    def know(self, plan: Plan) -> None:
        """Know a plan that is none of the study's, as that of a fork."""
        self._plans.setdefault(plan.key, plan)

    def note(self, call: Call) -> None:
        """Use one call: the step that its trial has come to, and what was paid for it."""
        if call.owed_anew:
            self._replies.pop(call.key, None)
            return
        if call.reply is None:
            return
        self._replies[call.key] = max(self._replies.get(call.key, 0), call.step)
        if not call.usage.input_tokens or (plan := self._plans.get(call.key)) is None:
            return
        self._counted += 1
        self._paid_out += self.price.of(Usage(output_tokens=call.usage.output_tokens))
        if call.turn == 1 and call.step <= plan.budget:
            self._first += 1
            self._paid_in += self.price.of(replace(call.usage, output_tokens=0))
            self._predicted += self._of(plan).tokens_in(call.step)

    def rest(self, key: str, calls: int = 0) -> float:
        """What is left to pay of a trial, at the estimate; after so many more ``calls``."""
        plan = self._plans[key]
        costs, made = self._of(plan), self._replies.get(key, 0) if plan.fork is None else self._of_fork(plan)
        step = min(made + calls, plan.budget)
        known = self._predicted > 0
        per_token = self._paid_in / self._predicted if known else self.price.input / 1e6
        per_reply = self._paid_out / self._counted if known else self.price.of(Usage(output_tokens=costs.output))
        repairs = self._counted / self._first if known else 1.0
        return repairs * (per_token * costs.tokens_after(step) + per_reply * (plan.budget - step))

    def last(self, key: str) -> float:
        """The upper bound of the cost of a trial's last call, which has to be left when it is made."""
        return self._of(self._plans[key]).last

    def _of_fork(self, plan: Plan) -> int:
        assert plan.fork is not None
        return max(plan.fork.name.at, self._replies.get(plan.key, 0))

    def _of(self, plan: Plan) -> _ConditionCosts:
        name = plan.condition.label
        if name not in self._conditions:
            sizes = PromptSizes(replace(plan, fork=None), self._settings, self._facts)
            output = assumed_output(sizes, self._settings, self._facts)
            self._conditions[name] = _ConditionCosts(sizes, plan.budget, round(output), self.price)
        return self._conditions[name]


class _ConditionCosts:
    """What trials of one condition are expected to take.

    Attributes:
        output: Assumed tokens of a reply, without calls.
        last: Upper bound of the cost of the last call, US dollars.
    """

    def __init__(self, sizes: PromptSizes, steps: int, output: int, price: Price) -> None:
        self.output, self.last = output, most_dollars(sizes.last(), price)
        self._tokens = [sizes.request(step).input for step in range(1, steps + 1)]
        self._after = [0.0, *accumulate(reversed(self._tokens))][::-1]

    def tokens_in(self, step: int) -> float:
        """Tokens of the request of a step."""
        return self._tokens[step - 1]

    def tokens_after(self, step: int) -> float:
        """Tokens of all requests after a step."""
        return self._after[step]
