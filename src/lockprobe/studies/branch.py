"""Forks of recorded trials (``lockprobe branch``): fork points, arms, and the plans that play them.

Forks are written to the directory ``forks`` of a study, in a separate journal with the study's settings. Their keys
name no trial of the study, so they are never counted as its trials.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind
from lockprobe.foundation.validation import check_choice, check_whole
from lockprobe.interventions.conditions import interventions_in, interventions_of
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.modality import interventions_for, is_pictured
from lockprobe.interventions.told import Correction
from lockprobe.statistics.branch import TRUTH, check_rule, fork_steps
from lockprobe.studies import FORKS
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.journal import Journal, facts_said, note
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE
from lockprobe.studies.running.executor import Limits, Observer
from lockprobe.studies.running.runner import run
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.plan import Fork, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import ForkName, Trial
from lockprobe.trial.source import false_reports

TOLD: Mapping[str, str] = {
    "truth": "",
    "lie": "flip?p=1&at={at}",
    "truth-truth": "correction?p=1&first=truth&at={at}",
    "lie-truth": "correction?p=1&at={at}",
    "truth-lie": "correction?p=1&first=truth&last=lie&at={at}",
    "lie-lie": "correction?p=1&last=lie&at={at}",
    "remark": "distract?p=1&at={at}",
    "withheld": "drop?p=1&at={at}",
}
"""Report at a fork -> the interventions that give it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Branching:
    """What is forked (:func:`branching`): trials by key, rules for fork points, and arms, ``truth`` first."""

    study: Study
    trials: Mapping[str, Trial]
    at: tuple[str, ...]
    arms: tuple[str, ...]
    truthful: bool = False
    times: int = 1

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents of the trials."""
        return tuple(dict.fromkeys(trial.agent for trial in self.trials.values()))

    def plans(self, agent: str) -> Iterator[Plan]:
        """The plans of one agent's forks. Continuations are the outermost loop, so that any part of them is balanced.

        If an unseeded agent's fork repeats the recorded report and all later ones, the fork equals the recorded trial
        and is planned only once.
        """
        unseeded = resolve(agent).engine == "network"
        of = [trial for trial in self.trials.values() if trial.agent == agent]
        places = [(one, at) for one in of for at in sorted({at for rule in self.at for at in fork_steps(one, rule)})]
        for time, (trial, at), arm in product(range(1, self.times + 1), places, self.arms):
            false = false_reports(trial)[at - 1 :]
            as_recorded = arm == ("lie" if false[0] else TRUTH) and not (self.truthful and any(false[1:]))
            if time == 1 or not (unseeded and as_recorded):
                name = ForkName(parent=trial.key, at=at, arm=arm, truthful=self.truthful, time=time)
                yield fork_plan(self.study, trial, name)


def fork_plan(study: Study, trial: Trial, name: ForkName) -> Plan:
    """The plan of a fork of a recorded trial."""
    plan = study.plan(trial.agent, study.labelled(trial.condition), trial.repetition, trial.trial)
    acting, changed = _changed(plan.condition, name.arm, name.at)
    fork = Fork(name=name, condition=trial.condition, acting=acting, recorded=trial.steps)
    return replace(plan, condition=changed, fork=fork)


def _changed(condition: Condition, arm: str, at: int) -> tuple[tuple[Intervention, ...], Condition]:
    """The interventions of an arm, and the condition that includes them; ``at`` is the step whose report is changed.

    What a false report is stays that of the condition, because of its later effects.

    Raises:
        BadValue: If there is no such arm, or the condition cannot tell it.
    """
    check_choice("told", arm, TOLD)
    own = interventions_in(condition)
    flips = [one for one in own if isinstance(one, OutcomeFlip)]
    like = flips[0] if flips else OutcomeFlip()
    if like.part == "position" and like.inverts == "outcome":
        expected = "one without part=position, whose false positions the true report of an arm would take back"
        raise BadValue("a condition to fork", condition.label, expected)
    if is_pictured(condition.modality) and arm not in ("truth", "lie", "remark"):
        raise BadValue("told", arm, f"truth, lie or remark with {condition.modality}")
    if like.others == "noisy":
        like = replace(like, others="fresh")  # a lie is on the attempted joint, not on all of them
    acting: tuple[Intervention, ...] = tuple(
        replace(one, inverts=like.inverts) if isinstance(one, Correction) else one
        for one in interventions_of(TOLD[arm].format(at=at))
    )
    forgetful = like.inverts == "position" and like.keep == 0  # a true report then owes nothing to those before it
    if arm == "lie":
        acting = (like.at_rate(1.0, at=(at,)),)
    elif flips and not forgetful:
        acting = (like.at_rate(0.0), *acting)
    return acting, replace(condition, interventions=(*own, *acting), name=f"fork: {arm}")


def branching(
    study: Study,
    records: Sequence[Trial],
    *,
    keys: Sequence[str] = (),
    at: Sequence[str] = ("4", "8", "12"),
    told: Sequence[str] = ("truth", "lie"),
    truthful: bool = False,
    times: int = 1,
) -> Branching:
    """Select the forks of a study. Trials that broke, and those of people and clients, are not forked.

    Args:
        study: The study.
        records: Its recorded trials.
        keys: Keys of trials, or prefixes of keys; all trials without keys.
        at: Fork points: numbers of steps, or rules.
        told: Reports given at the fork; ``truth`` is always added as the control.
        truthful: Whether all later reports are true; else they follow the trial's condition.
        times: Continuations per arm.

    Raises:
        BadValue: If there is no such fork point or arm, or nothing is left to fork.
        UnknownName: If there is no such trial.
    """
    check_whole("times", times, 1, 1000)
    for rule in at:
        check_rule(rule)
    chosen = {} if keys else {trial.key: trial for trial in records}
    for key in keys:
        found = {trial.key: trial for trial in records if f"{trial.key}/".startswith(f"{key}/")}
        if not found:
            raise UnknownName("trial", key, [trial.key for trial in records][:12])
        chosen |= found
    able = [one for one in chosen.values() if one.ending != "error" and spec_kind(one.agent) not in (PEOPLE, MCP)]
    forked = {trial.key: trial for trial in able if any(fork_steps(trial, rule) for rule in at)}
    if not forked:
        longest = max((len(trial.steps) for trial in able), default=1) - 1
        raise BadValue(
            "at", ", ".join(at), f"a step up to {longest}, after which a trial goes on that no person played"
        )
    arms = tuple(dict.fromkeys([TRUTH, *told]))
    for label, arm in product({trial.condition for trial in forked.values()}, arms):
        interventions_for(_changed(study.labelled(label), arm, 1)[1])
    return Branching(study=study, trials=forked, at=tuple(at), arms=arms, truthful=truthful, times=times)


def play_forks(
    asked: Branching, journal: Journal, *, limits: Limits | None = None, observer: Observer | None = None
) -> None:
    """Play the forks that ``journal``, in the directory :data:`FORKS`, owes, as a study is run.

    Calls that are recorded in the study are not made again.
    """
    journal.calls.adopt(call for call in read_calls(journal.directory.parent) if call.key in asked.trials)
    for trial in asked.trials.values():  # model, prompt and runtime must be the same as in these
        note(journal.known, facts_said(trial))
    study = replace(asked.study, agents=asked.agents)
    run(study, journal, limits=limits, observer=observer, plans=asked.plans)


def read_forks(directory: Path | str) -> list[Trial]:
    """The recorded forks in the directory of a study; empty if none was played."""
    forks = Path(directory) / FORKS
    return load(forks) if is_there(forks / STORE) else []
