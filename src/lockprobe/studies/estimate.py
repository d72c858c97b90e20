"""Estimates the cost of the trials that a study still owes, before any request is made.

The number of steps is not known in advance. An agent with finished trials is assumed to continue at its observed
rate; interrupted trials are censored observations (Kaplan and Meier, JASA 1958). For steps that no trial has reached,
the agent is assumed to perform like a random agent, computed exactly. The size of the requests is known: they are
conversations that grow by a reply and an observation with every step.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from lockprobe.agents.llm.model_facts import Price, facts_of
from lockprobe.agents.llm.settings import read_settings
from lockprobe.lockbox.solve import random_curve
from lockprobe.model_call import Call, Usage
from lockprobe.record import Trial
from lockprobe.studies.request_sizes import PromptSizes, Request
from lockprobe.studies.spending import hosted, most_dollars
from lockprobe.studies.study import Study

__all__ = ["Estimate", "estimates", "most_of_one_call", "together"]

_REASONING = 1000
"""Tokens of reasoning before a reply where nothing has been played; models differ by more than tenfold."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """What the trials that one agent owes will cost.

    Attributes:
        agent: Its spec.
        trials: Trials owed.
        rests_on: Replies of this agent that the estimate rests on; 0 where it has played nothing.
        expected: What they should take. Tokens cached and stored are those that a provider can keep, at best.
        full: The same if no trial is solved before its steps run out.
        most: What they can take, whatever is replied; malformed replies, which are asked for again, come on top.
        repeated: Share of the tokens read that repeat the start of the request before.
        price: What its provider asks; None where that is not known.
        batch: Whether it goes through the batch interface.
    """

    agent: str
    trials: int
    rests_on: int
    expected: Usage
    full: Usage
    most: Usage
    repeated: float
    price: Price | None
    batch: bool = False

    def dollars(self, usage: Usage, *, cached: bool) -> float | None:
        """What a usage costs this agent, with its provider's cache at its best or without one; None if not known."""
        if self.price is None:
            return None
        usage = usage if cached else replace(usage, cached_tokens=0, stored_tokens=0)
        return self.price.of(usage, batch=self.batch)

    @property
    def most_dollars(self) -> float | None:
        """What they can cost, whatever is replied; None where the price is not known."""
        return None if self.price is None else most_dollars(self.most, self.price)


def estimates(
    study: Study, done: Mapping[str, Trial], calls: Iterable[Call] = (), *, batch: bool = False
) -> list[Estimate]:
    """What the owed trials of every agent that asks a provider will cost; agents that owe nothing are left out.

    Args:
        study: The study.
        done: Its trials on record, by key.
        calls: Its calls on record.
        batch: Whether providers' batch interfaces are used.
    """
    agents = [_AgentEstimator(study, agent, done) for agent in hosted(study)]
    owners = {key: agent for agent in agents for key in agent.keys}
    for call in calls if agents else ():
        if (agent := owners.get(call.key)) is not None:
            agent.note(call)
    found = (agent.estimate(batch=batch) for agent in agents)
    return [estimate for estimate in found if estimate.trials]


def together(found: Iterable[Estimate]) -> list[Estimate]:
    """The estimates of several studies added up, one for each agent."""
    sums: dict[str, Estimate] = {}
    for one in found:
        first = sums.get(one.agent)
        sums[one.agent] = one if first is None else _added(first, one)
    return list(sums.values())


def _added(first: Estimate, second: Estimate) -> Estimate:
    read = [one.expected.input_tokens for one in (first, second)]
    repeated = first.repeated * read[0] + second.repeated * read[1]
    return replace(
        first,
        trials=first.trials + second.trials,
        rests_on=first.rests_on + second.rests_on,
        expected=first.expected + second.expected,
        full=first.full + second.full,
        most=first.most + second.most,
        repeated=repeated / sum(read) if sum(read) else 0.0,
    )


def most_of_one_call(study: Study, agent: str) -> float:
    """What the first call of a trial can cost, in US dollars, whatever is replied; 0 where no price is known."""
    name, settings = read_settings(agent)
    facts = facts_of(name)
    if facts.price is None:
        return 0.0
    plans = (study.plan(agent, condition, 1, 1) for condition in study.conditions_of(agent))
    return min(most_dollars(PromptSizes(plan, settings, facts).first(), facts.price) for plan in plans)


class _AgentEstimator:
    """One agent: its prompts, and what is known of its play."""

    def __init__(self, study: Study, agent: str, done: Mapping[str, Trial]) -> None:
        self._study, self._agent = study, agent
        name, self._settings = read_settings(agent)
        self._facts = facts_of(name)
        self._shown = {plan.key: plan.condition for plan in study.plans(agent)}
        self._done = {
            # a malformed reply ends a trial in a step that is not played
            key: len(trial.steps) + (trial.error is not None)
            for key, trial in done.items()
            if key in self._shown and not trial.owed_again
        }
        self._prompts = {
            condition: PromptSizes(study.plan(agent, condition, 1, 1), self._settings, self._facts)
            for condition in study.conditions_of(agent)
        }
        self._made: Counter[str] = Counter()
        self._reached: Counter[str] = Counter()
        self._replies = self._counted = self._first = self._output = self._input = 0
        self._taken = 0.0

    @property
    def keys(self) -> Iterable[str]:
        """Its trials."""
        return self._shown

    def note(self, call: Call) -> None:
        """One call on record: where its trial goes on if it was broken off, and how large requests and replies are."""
        if call.owed_anew:
            self._made[call.key] = self._reached[call.key] = 0
            return
        self._reached[call.key] = max(self._reached[call.key], min(call.step, self._study.max_steps))
        if call.reply is None:
            return
        self._replies += 1
        self._made[call.key] = max(self._made[call.key], call.step)
        if not call.usage.input_tokens:
            return
        self._counted += 1
        self._output += call.usage.output_tokens
        if call.turn == 1 and call.step <= self._study.max_steps:
            self._first += 1
            self._input += call.usage.input_tokens
            self._taken += self._prompts[self._shown[call.key]].request(call.step).input

    def estimate(self, *, batch: bool) -> Estimate:
        """What is owed, counted by what was shown and where it was broken off."""
        owed = Counter(
            (shown, self._made[key], self._reached[key]) for key, shown in self._shown.items() if key not in self._done
        )
        coming_to = self._survival()
        longer, output, repairs = self._habits()
        expected, full, most, repeated = _UsageSum(), _UsageSum(), Usage(), 0.0
        for (shown, begun, reached), trials in owed.items():
            prompt = self._prompts[shown]
            for step in range(begun + 1, self._study.max_steps + 1):
                request, times = prompt.request(step, longer), trials * repairs
                share = coming_to[step] / coming_to[reached] if step > reached else 1.0
                written = self._written(prompt) if output is None else output
                expected.add(request, written, times * share)
                full.add(request, written, times)
                repeated += prompt.repeated(step, longer) * times * share
            most += prompt.most(begun + 1, trials)
        return Estimate(
            agent=self._agent,
            trials=sum(owed.values()),
            rests_on=self._replies,
            expected=expected.usage,
            full=full.usage,
            most=most,
            repeated=repeated / expected.input if expected.input else 0.0,
            price=self._facts.price,
            batch=batch,
        )

    def _survival(self) -> list[float]:
        """For every step, from 0, the share of trials that come to it; above 0 up to where the farthest of them is."""
        steps = self._study.max_steps
        blind = [1 - solved for solved in random_curve(self._study.box, steps)]
        ended = Counter(self._done.values())
        stands = Counter(step for key, step in self._reached.items() if key not in self._done)
        playing, shares = ended.total() + stands.total(), [1.0, 1.0]
        for step in range(1, steps):
            playing -= stands[step]  # whether they end in this step is not known
            seen = 1 - ended[step] / playing if playing else blind[step] / (blind[step - 1] or 1.0)
            playing -= ended[step]
            shares.append(shares[-1] * seen)
        return shares

    def _habits(self) -> tuple[float, float | None, float]:
        """Requests as multiples of what they are taken to be; tokens of a reply, if known; calls per decision."""
        if self._taken:
            return self._input / self._taken, self._output / self._counted, self._counted / self._first
        return 1.0, None, 1.0

    def _written(self, prompt: PromptSizes) -> float:
        """Tokens of a reply where nothing has been played."""
        reasons = self._facts.reasons or self._settings.effort not in (None, "none")
        output = prompt.output + (_REASONING if reasons else 0)
        return min(output, self._settings.most_tokens(self._facts) or output)


class _UsageSum:
    """Adds requests up, of which not every one has to be made."""

    def __init__(self) -> None:
        self.calls = self.input = self.cached = self.stored = self.output = 0.0

    def add(self, request: Request, output: float, times: float) -> None:
        self.calls += times
        self.input += times * request.input
        self.cached += times * request.cached
        self.stored += times * request.stored
        self.output += times * output

    @property
    def usage(self) -> Usage:
        return Usage(
            calls=round(self.calls),
            input_tokens=round(self.input),
            output_tokens=round(self.output),
            cached_tokens=round(self.cached),
            stored_tokens=round(self.stored),
        )
