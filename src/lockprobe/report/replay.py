"""Recorded trials played again: whether truth and reports follow from the choices, and the choices from their agent.

Strategies are asked again. A hosted model decides again by the replies in the log of its calls, a local one by its
recorded probabilities and the random stream of the trial. All others choose what is on record. What a camera read in
pictures for reports (:mod:`lockprobe.trial.source`) is taken from the record. No code of a user or of another package
runs, and no model is asked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from itertools import zip_longest
from typing import Any, Literal

import numpy as np

from lockprobe.agents.catalogue import is_local, is_strategy, resolve
from lockprobe.agents.llm.asking_again import decided
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.prompt import prompt_fingerprint
from lockprobe.agents.reply import parse_reply
from lockprobe.foundation.errors import ModelFault, NotHere, ReplyFault, UserMistake
from lockprobe.foundation.plugins import plugin_names
from lockprobe.foundation.spec import MCP, PEOPLE, Spec, spec_kind, spec_name
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.costs.call_log import take
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Briefing, Decision, Fact, Percept, Situation, Task, Trial
from lockprobe.trial.trial_json import trial_to_json

AgentKind = Literal["strategy", "hosted", "local", "outside", "own"]
"""How choices can be held against something: asked again; by replies; by probabilities; by the log of a server of
people or clients; by nothing, since the code is a user's or of another package."""


@dataclass(slots=True, kw_only=True)
class ReplayedTrial:
    """What of a recorded trial follows.

    Attributes:
        luck: Why truth or reports do not follow from the choices, the box and the seed; empty if they do.
        choices: Why the choices do not follow from the agent, its replies or its probabilities; empty if they do.
        unplayed: Why it cannot be played again, as the end of a sentence: no code of others runs, no robot or person
            moves a joint, a file is not here; empty if it is.
    """

    key: str
    kind: AgentKind
    luck: str = ""
    choices: str = ""
    unplayed: str = ""


def kind_of(agent: str) -> AgentKind:
    """The kind of an agent, by its spec. Nothing is imported for it."""
    kind = spec_kind(agent)
    if is_strategy(agent):
        return "strategy"
    if kind == "llm":
        return "local" if is_local(Spec.parse(agent)) else "hosted"
    return "outside" if kind in (PEOPLE, MCP) else "own"


def is_foreign(kind: Literal["plant", "intervention"], spec: str) -> bool:
    """Whether a spec names code of a user or of another package."""
    added = {*plugin_names(kind), *(plugin_names("plant source") if kind == "plant" else ())}
    return spec_kind(spec) == "python" or spec_name(spec) in added


async def played_again(
    plan: Plan, trial: Trial, replies: Sequence[Call] = (), parent: Sequence[Call] = ()
) -> ReplayedTrial:
    """Play a recorded trial again by its plan.

    ``replies`` are those in the log of calls, if a hosted model played it, ``parent`` those of the trial that it forks.
    """
    found = ReplayedTrial(key=trial.key, kind=kind_of(trial.agent))

    def unplayed(why: str) -> ReplayedTrial:
        others = _other_replies(trial, replies) if found.kind == "hosted" and not parent else ""
        return replace(found, unplayed=why, choices=others)

    try:
        foreign = any(is_foreign("intervention", one) for one in plan.condition.specs)
        if foreign or is_foreign("plant", plan.plant) or resolve_plant(plan.plant).is_attended():
            return unplayed("need a plant or an intervention that does not ship, or a real box, and are not played")
        kept = [*replies]
        agent = _agent(trial, found.kind, kept, [*parent])
        found.luck = await _difference(plan, trial, agent)
        if found.luck and not isinstance(agent, _Recorded):  # whether the rest follows from these choices
            found.luck, found.choices = await _difference(plan, trial, _Recorded(trial)), found.luck
            if found.kind == "hosted" and trial.facts.get("prompt") != prompt_fingerprint():
                found.choices += "; its prompt is not that of this release, so verify it with its own"
        if found.kind == "hosted" and kept and not found.choices:
            found.choices = f"{len(kept)} replies in the log of calls are no part of the record"
    except NotHere as missing:
        return unplayed(f"are not checked: {missing.path} is not here")
    except UserMistake as mistake:
        found.luck = str(mistake)
    return found


def _agent(trial: Trial, kind: AgentKind, *kept: list[Call]) -> Agent:
    """The agent that decides again as far as it can be held against something, else one that does as on record."""
    if kind == "strategy":
        return _strategy(trial.agent)
    if kind == "local":
        return _Redrawn(trial)
    if kind == "hosted":
        return _Answered(trial, kept)
    return _Recorded(trial)


@cache
def _strategy(spec: str) -> Agent:
    return resolve(spec).make()


class _Recorded:
    """An agent that chooses what is on record; at the end of a broken record it breaks too."""

    def __init__(self, trial: Trial) -> None:
        self._decisions = iter([step.decision for step in trial.steps])
        self.facts: Mapping[str, Fact] = trial.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The next choice on record."""
        for decision in self._decisions:
            return decision
        raise ModelFault("the record ends here")


class _Answered:
    """A hosted model that decides again by the replies on record, and is not asked.

    Its settings are those of the record, so that each request has to be the one that was sent.
    """

    unseeded = True

    def __init__(self, trial: Trial, kept: Sequence[list[Call]]) -> None:
        self._model, self._kept, self.facts = Model.as_sent(trial.agent, trial.facts), kept, trial.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Decide by the replies, each of which is there for one request."""

        async def ask(new: Call, *asked: object) -> Call:
            if (known := take(self._kept, new.step, new.turn, new.request)) is None:
                raise ModelFault("there is no such reply")
            return known

        return await decided(situation, self._model, ask)


class _Redrawn:
    """A local model that draws again from the probabilities on record, and scores nothing."""

    def __init__(self, trial: Trial) -> None:
        self._recorded, self.facts = _Recorded(trial), trial.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The claim and the joint that the stream gives."""
        from lockprobe.agents.local import drawn

        recorded = await self._recorded.decide(situation, rng)
        if recorded.probabilities is None:
            raise ModelFault("the record has no probabilities")
        chances = recorded.probabilities
        return drawn(situation, recorded.claim_probability, lambda _: chances, rng)


async def _difference(plan: Plan, trial: Trial, agent: Agent) -> str:
    """What of a trial does not follow; empty if all does. Trials broken outside their agent count up to their break."""
    again, _ = await play_timed(plan, agent, recorded=trial)
    recorded = isinstance(agent, _Recorded)
    if trial_to_json(trial) == trial_to_json(again):
        return ""
    for before, now in zip(trial.steps, again.steps, strict=False):
        if before != now:
            parts = _changed(before.decision, now.decision)
            said = (f"decision ({', '.join(parts)})" if name == "decision" else name for name in _changed(before, now))
            return f"step {before.step}, {', '.join(said)}"
    if recorded and trial.error is not None and again.error is None:
        return f"the steps end as {again.ending}, not as an error"
    if len(again.steps) < len(trial.steps):
        return f"step {len(again.steps) + 1}: {'' if again.error is None else again.error.message}"
    names = _changed(trial, again)
    if trial.error is not None and (trial.owed_again or recorded):  # how it broke is not played again
        names = [name for name in names if name.startswith("opening") or name in ("joints", "labels", "listing")]
    other = next(iter(names), "")
    return f"it ends as {again.ending}, not as {trial.ending}" if other == "ending" else other


def _changed(before: Any, now: Any) -> list[str]:
    """The fields in which two records differ."""
    return [one.name for one in fields(before) if getattr(before, one.name) != getattr(now, one.name)]


def _other_replies(trial: Trial, logged: Sequence[Call]) -> str:
    """Where decisions and errors of a trial that is not played again are not its replies in the log of calls.

    Without the plant nobody knows the requests. But the words of every reply are on record twice.
    """
    recorded = [(step.step, reply) for step in trial.steps for reply in step.decision.replies]
    if trial.error is not None:
        recorded += [(trial.error.step, reply) for reply in trial.error.replies]
    replies = [(call.step, call.reply) for call in logged]
    if trial.owed_again:  # the replies of the step that broke are of no decision
        replies = replies[: len(recorded)]
    for one, other in zip_longest(recorded, replies):
        if one != other:
            return f"step {(one or other or (0,))[0]}, replies"
    labels, before = dict(zip(trial.joints, trial.labels, strict=True)), None
    for step in trial.steps:
        decision, assessed = step.decision, step.decision.claimed is not None
        task = Task(joints=trial.listing, target=trial.target, budget=trial.budget, assessment=assessed)
        now = Situation(task=task, past=(), percept=Percept(joint=before), briefing=Briefing(hypothesis="off"))
        try:
            said = parse_reply(decision.replies[-1], now) if decision.replies else None
        except ReplyFault:  # only its request says what it means
            said = decision
        if said is None or (said.joint, said.claimed) != (decision.joint, decision.claimed):
            return f"step {step.step}, decision"
        before = labels.get(step.joint)
    return ""
