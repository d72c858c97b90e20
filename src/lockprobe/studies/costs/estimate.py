"""Cost estimates of the trials that a study still owes, before any request is made.

The number of steps is not known in advance. An agent with finished trials is assumed to continue at its observed
rate; interrupted trials are censored observations (Kaplan and Meier, JASA 1958). For steps that no trial has reached,
the agent is assumed to perform like a random agent, computed exactly. The size of the requests is counted in a made-up
trial of each condition (:mod:`lockprobe.studies.costs.dry_trial`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.agents.llm.model_facts import Price, price_of
from lockprobe.agents.llm.settings import Model
from lockprobe.boxes.solve import random_curve
from lockprobe.studies.costs.dry_trial import Array, DryTrial
from lockprobe.studies.costs.spending import hosted, most_dollars
from lockprobe.studies.records.trial_rows import OnRecord
from lockprobe.studies.stopping import at_most
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.model_call import Call, Usage

SMALLEST_CACHED = 1024
"""Tokens below which providers keep no prefix (OpenAI's and Anthropic's guides to prompt caching; some models 2048)."""

_REASONING = 1000
"""Assumed tokens of reasoning before a reply without history; models differ by more than tenfold."""

_Stand = tuple[Condition, int, int]
"""Where trials stand: their condition, the replies that are on record, and the step that was reached."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """The estimated cost of the trials that one agent owes; of a study with ``until``, of those that it owes at most.

    Attributes:
        agent: Agent spec.
        trials: Trials owed.
        rests_on: Number of recorded replies behind the estimate; 0 for an agent without history.
        expected: Expected usage. Cached and stored tokens assume the provider's cache at its best.
        full: Usage if no trial is solved within its budget of steps.
        most: Upper bound of the usage, whatever the replies; retries of malformed replies are extra.
        repeated: Share of the input tokens that repeat the start of the request before.
        price: The provider's price; None if it is not known.
        called: What the study calls the agent.
        until: When the study stops, if that is before all trials are played; else empty.
    """

    agent: str
    called: str
    trials: int
    rests_on: int
    expected: Usage
    full: Usage
    most: Usage
    repeated: float
    price: Price | None
    until: str = ""

    def dollars(self, usage: Usage, *, cached: bool) -> float | None:
        """The cost of a usage in US dollars, with the provider's cache at its best or without; None if not known."""
        if self.price is None:
            return None
        usage = usage if cached else replace(usage, cached_tokens=0, stored_tokens=0)
        return self.price.of(usage)

    @property
    def most_dollars(self) -> float | None:
        """Upper bound of the cost in US dollars, whatever the replies; None if the price is not known."""
        return None if self.price is None else most_dollars(self.most, self.price)


def estimates(study: Study, done: Mapping[str, OnRecord], calls: Iterable[Call] = ()) -> list[Estimate]:
    """The estimated cost of the owed trials of every hosted agent; agents that owe nothing are left out.

    Args:
        study: The study.
        done: Its recorded trials, by key.
        calls: Its recorded calls.
    """
    agents = [_AgentEstimator(study, agent, done) for agent in hosted(study)]
    owners = {key: agent for agent in agents for key in agent.keys}
    for call in calls if agents else ():
        if (agent := owners.get(call.key)) is not None:
            agent.note(call)
    found = (agent.estimate() for agent in agents)
    return [estimate for estimate in found if estimate.trials]


class _AgentEstimator:
    """Collects what is known about one agent: sizes of its prompts and its finished play."""

    def __init__(self, study: Study, agent: str, done: Mapping[str, OnRecord]) -> None:
        self._study, self._agent = study, agent
        self._model = Model.parse(agent)
        self._price = price_of(self._model.name)
        self._shown = {plan.key: plan.condition for plan in study.plans(agent)}
        self._trials = done
        self._done = {
            # a malformed reply ends a trial in a step that is not played
            key: trial.length + (trial.ending == "error")
            for key, trial in done.items()
            if key in self._shown and not trial.owed_again
        }
        self._dry = {
            condition: DryTrial.of(study.plan(agent, condition, 1, 1), self._model)
            for condition in study.conditions_of(agent)
        }
        self._made: Counter[str] = Counter()
        self._reached: Counter[str] = Counter()
        self._replies = self._counted = self._first = self._output = self._input = 0
        self._taken = 0.0

    @property
    def keys(self) -> Iterable[str]:
        """The keys of its trials."""
        return self._shown

    def note(self, call: Call) -> None:
        """Use one recorded call: the step at which an interrupted trial resumes, and the sizes of request and reply."""
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
            self._taken += float(self._dry[self._shown[call.key]].input[call.step - 1])

    def estimate(self) -> Estimate:
        """The estimate for the owed trials, by condition and by the step at which they resume."""
        if self._study.until is None:
            keys = [key for key in self._shown if key not in self._done]
        else:  # those that it owes at most
            keys = [plan.key for plan in at_most(self._study, self._agent, self._trials.values())]
        owed = Counter((self._shown[key], self._made[key], self._reached[key]) for key in keys)
        expected, full = self._decisions(owed)
        usage, repeated = self._usage(expected)
        return Estimate(
            agent=self._agent,
            called=self._study.label_of(self._agent),
            trials=owed.total(),
            rests_on=self._replies,
            expected=usage,
            full=self._usage(full)[0],
            most=Usage(
                calls=round(sum(float(times.sum()) for times in full.values())),
                input_tokens=round(sum(float(self._dry[one].most_input @ times) for one, times in full.items())),
                output_tokens=round(sum(float(self._dry[one].most_output @ times) for one, times in full.items())),
            ),
            repeated=repeated,
            price=self._price,
            until=str(self._study.until or ""),
        )

    def _decisions(self, owed: Mapping[_Stand, int]) -> tuple[dict[Condition, Array], dict[Condition, Array]]:
        """Condition -> expected decisions in each step, and those of trials that are all played to the last step."""
        coming_to = np.array(self._survival())
        expected, full = ({one: np.zeros(self._study.max_steps) for one in self._dry} for _ in range(2))
        for (shown, begun, reached), trials in owed.items():
            share = np.ones(self._study.max_steps)
            share[reached:] = coming_to[reached + 1 :] / coming_to[reached]
            full[shown][begun:] += trials
            expected[shown][begun:] += trials * share[begun:]
        return expected, full

    def _usage(self, decisions: Mapping[Condition, Array]) -> tuple[Usage, float]:
        """The usage of decisions, and the share of their input that repeats the request before."""
        longer = self._input / self._taken if self._taken else 1.0  # requests relative to the dry trial
        repairs = self._counted / self._first if self._taken else 1.0  # calls per decision
        sums, again = np.zeros(5), 0.0
        for shown, times in decisions.items():
            dry = self._dry[shown]
            size, repeated = longer * dry.input, longer * dry.repeated
            cached = np.where(repeated >= SMALLEST_CACHED, repeated, 0.0)
            stored = np.where(size >= SMALLEST_CACHED, size - cached, 0.0)
            written = self._output / self._counted if self._taken else self._assumed_output(dry)
            each = [np.ones_like(size), size, np.full_like(size, written), cached, stored]
            sums += repairs * np.array(each) @ times
            again += repairs * float(repeated @ times)
        names = ("calls", "input_tokens", "output_tokens", "cached_tokens", "stored_tokens")
        usage = Usage(**dict(zip(names, map(round, sums.tolist()), strict=True)))
        return usage, again / sums[1] if sums[1] else 0.0

    def _assumed_output(self, dry: DryTrial) -> float:
        """Assumed tokens of a reply for an agent without history."""
        reasons = self._model.facts.reasons or self._model.settings.effort not in (None, "none")
        output = dry.output + (_REASONING if reasons else 0)
        return min(output, self._model.most_tokens or output)

    def _survival(self) -> list[float]:
        """Kaplan-Meier survival: for every step from 0 the share of trials that reach it."""
        steps = self._study.max_steps
        blind = 1 - np.mean([random_curve(box, steps) for box in self._study.boxes], axis=0)
        ended = Counter(self._done.values())
        stands = Counter(step for key, step in self._reached.items() if key not in self._done)
        playing, shares = ended.total() + stands.total(), [1.0, 1.0]
        for step in range(1, steps):
            playing -= stands[step]  # whether they end in this step is not known
            seen = 1 - ended[step] / playing if playing else blind[step] / (blind[step - 1] or 1.0)
            playing -= ended[step]
            shares.append(shares[-1] * seen)
        return shares
