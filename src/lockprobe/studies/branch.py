"""Forks of recorded trials (``lockprobe branch``): fork points, arms, and the plans that play them.

Forks are written to the directory ``forks`` of a study, in a separate journal with the study's settings. Their keys
name no trial of the study, so they are never counted as its trials.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind
from lockprobe.foundation.validation import check_choice, check_whole
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.misread_flip import takes_rates
from lockprobe.interventions.told import Correction
from lockprobe.statistics.branch import TRUTH, check_rule, fork_steps
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.modality import interventions_for, is_pictured
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE
from lockprobe.studies.running.executor import Limits, Observer
from lockprobe.studies.running.runner import run
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.plan import Fork, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Trial
from lockprobe.trial.told_outcome import false_reports
from lockprobe.trial.trial_name import ForkName

FORKS = "forks"
"""The directory of forks in that of their study."""

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

ACTS: Mapping[str, str] = {
    "tremble": "tremble?p=1&at={after}",
    "random": "force?at={after}",
    "force": "force?at={after}&joint={joint}",
}
"""Action in the step after a fork with a true report -> the interventions that force it."""

_PICTURED = ("truth", "lie", "remark")
"""Reports that pictures can give."""

_MOST = 1000
"""Continuations of one arm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Branching:
    """A request for forks: recorded trials, fork points and arms.

    Attributes:
        study: The study.
        trials: Its trials to fork, by key.
        at: Fork points: rules for :func:`lockprobe.statistics.branch.fork_steps`.
        arms: Names of the arms (what is told or done), ``truth`` first.
        truthful: Whether all later reports are true.
        times: Continuations per arm.
        left: Why trials are not forked -> how many.
    """

    study: Study
    trials: Mapping[str, Trial]
    at: tuple[str, ...]
    arms: tuple[str, ...]
    truthful: bool = False
    times: int = 1
    left: Mapping[str, int] = field(default_factory=dict)

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
        steps = {trial.key: sorted({at for rule in self.at for at in fork_steps(trial, rule)}) for trial in of}
        for time in range(1, self.times + 1):
            for trial in of:
                for at in steps[trial.key]:
                    for arm in self.arms:
                        name = ForkName(parent=trial.key, at=at, arm=arm, truthful=self.truthful, time=time)
                        if time == 1 or not (unseeded and self._as_recorded(trial, name)):
                            yield fork_plan(self.study, trial, name)

    def _as_recorded(self, trial: Trial, name: ForkName) -> bool:
        """Whether a fork gives the same reports as the record, at the fork and later."""
        false = false_reports(trial)[name.at - 1 :]
        return name.arm == ("lie" if false[0] else TRUTH) and not (name.truthful and any(false[1:]))


def fork_plan(study: Study, trial: Trial, name: ForkName) -> Plan:
    """The plan of a fork of a recorded trial.

    Raises:
        BadValue: If there is no such arm, or the condition cannot tell it.
    """
    condition = _condition(study, trial)
    plan = study.plan(trial.agent, condition, trial.repetition, trial.trial)
    changes = _changed if takes_rates(plan.condition.specs) else _changed_for_all
    joint = name.arm.partition("=")[2]
    label = trial.labels[trial.joints.index(joint)] if joint else ""
    acting, changed = changes(plan.condition, name.arm, name.at, label)
    fork = Fork(name=name, condition=condition.label, acting=acting, recorded=trial.steps)
    return replace(plan, condition=changed, fork=fork)


def _condition(study: Study, trial: Trial) -> Condition:
    found = study.condition_of(trial)
    assert found is not None  # only trials of the study are forked
    return found


def _changed(condition: Condition, arm: str, at: int, label: str) -> tuple[tuple[Intervention, ...], Condition]:
    """The interventions of an arm, and the condition that includes them."""
    acting = arm_interventions(arm, at, condition, label)
    interventions = (*interventions_in(condition), *acting)
    return acting, replace(condition, interventions=interventions, name=f"fork: {arm}")


_changed_for_all = lru_cache(maxsize=1024)(_changed)
"""The same, made once; not for conditions that are equal and yet have their rates under other labels in each."""


def arm_interventions(arm: str, at: int, condition: Condition, label: str = "") -> tuple[Intervention, ...]:
    """The interventions of an arm. What a false report is stays that of the condition, because of its later effects.

    Args:
        arm: One of :data:`TOLD` or :data:`ACTS`, which include ``force=JOINT``.
        at: The step whose report is changed.
        condition: The condition of the trial.
        label: The label of the joint that ``force=JOINT`` names.

    Raises:
        BadValue: If there is no such arm, or the condition cannot tell it.
    """
    kind, _, joint = arm.partition("=")
    if arm not in TOLD and (kind not in ACTS or (kind == "force") != bool(joint)):
        known = ", ".join([*TOLD, *(f"{one}=JOINT" if one == "force" else one for one in ACTS)])
        raise BadValue("arm", arm, f"one of {known}")
    if is_pictured(condition.modality) and arm in TOLD and arm not in _PICTURED:
        raise BadValue("told", arm, f"{', '.join(_PICTURED)} with {condition.modality}: a picture cannot be {arm}")
    spec = (TOLD.get(arm) or ACTS.get(kind, "")).format(at=at, after=at + 1, joint=label)
    flips = [one for one in interventions_in(condition) if isinstance(one, OutcomeFlip)]
    like = flips[0] if flips else OutcomeFlip()
    if like.part == "position" and like.inverts == "outcome":
        expected = "one without part=position, whose false positions the true report of an arm would take back"
        raise BadValue("a condition to fork", condition.label, expected)
    if like.others == "noisy":
        like = replace(like, others="fresh")  # a lie is on the attempted joint, not on all of them
    made = tuple(
        replace(one, inverts=like.inverts) if isinstance(one, Correction) else one for one in interventions_of(spec)
    )
    if arm == "lie":
        return (like.at_rate(1.0, at=(at,)),)
    forgetful = like.inverts == "position" and like.keep == 0  # a true report then owes nothing to those before it
    return made if not flips or forgetful else (like.at_rate(0.0), *made)


def branching(
    study: Study,
    records: Sequence[Trial],
    *,
    keys: Sequence[str] = (),
    at: Sequence[str] = ("4", "8", "12"),
    told: Sequence[str] = ("truth", "lie"),
    act: Sequence[str] = (),
    truthful: bool = False,
    times: int = 1,
) -> Branching:
    """Select the forks of a study.

    Args:
        study: The study.
        records: Its recorded trials.
        keys: Keys of trials, or prefixes of keys; all trials without keys.
        at: Fork points: numbers of steps, or rules.
        told: Reports given at the fork; ``truth`` is always added as the control.
        act: Actions forced in the step after the fork.
        truthful: Whether all later reports are true; else they follow the trial's condition.
        times: Continuations per arm.

    Raises:
        BadValue: If there is no such fork point or arm, a named trial has none of the fork points, ended as error or
            was played by a person, or nothing is left to fork.
        UnknownName: If there is no such trial.
    """
    check_whole("times", times, 1, _MOST)
    for rule in at:
        check_rule(rule)
    for arm in told:
        check_choice("told", arm, TOLD)
    for arm in act:
        if arm in TOLD or arm.partition("=")[0] not in ACTS:
            raise BadValue("act", arm, "one of tremble, random, force=JOINT")
    own = {trial.key: trial for trial in records}
    chosen = _chosen(own, keys)
    forked, left = _forkable(chosen, at)
    arms = tuple(dict.fromkeys([TRUTH, *told, *act]))
    for condition in {_condition(study, trial).label: _condition(study, trial) for trial in forked.values()}.values():
        for arm in arms:
            joint, known = arm.partition("=")[2], [name for box in study.boxes for name in box.names]
            if joint and joint not in known:
                raise BadValue("act", arm, f"force= with one of {', '.join(known)}")
            acting = arm_interventions(arm, 1, condition)
            shown = replace(condition, interventions=(*interventions_in(condition), *acting), name="")
            interventions_for(shown)
    return Branching(study=study, trials=forked, at=tuple(at), arms=arms, truthful=truthful, times=times, left=left)


def play_forks(
    asked: Branching, journal: Journal, *, limits: Limits | None = None, observer: Observer | None = None
) -> None:
    """Play the forks that a journal owes. Calls that are recorded in the study are not made again.

    Args:
        asked: The forks.
        journal: The journal in the directory :data:`FORKS` of the study's directory.
        limits: Limits of concurrency.
        observer: Receives the progress.

    Raises:
        UserMistake: As :func:`lockprobe.studies.running.runner.run`.
        BudgetReached: As :func:`lockprobe.studies.running.runner.run`.
    """
    journal.calls.adopt(call for call in read_calls(journal.directory.parent) if call.key in asked.trials)
    study = replace(asked.study, agents=asked.agents)
    run(study, journal, limits=limits, observer=observer, plans=asked.plans, known=asked.trials.values())


def read_forks(directory: Path | str) -> list[Trial]:
    """The recorded forks in the directory of a study; empty if none was played.

    Raises:
        BadFile: If a record is damaged.
    """
    forks = Path(directory) / FORKS
    return load(forks) if is_there(forks / STORE) else []


def _chosen(own: Mapping[str, Trial], keys: Sequence[str]) -> dict[str, Trial]:
    chosen = {} if keys else dict(own)
    for key in keys:
        found = {key: own[key]} if key in own else {one: own[one] for one in own if one.startswith(f"{key}/")}
        if not found:
            raise UnknownName("trial", key, list(own)[:12])
        chosen |= found
    return chosen


def _forkable(chosen: Mapping[str, Trial], at: Sequence[str]) -> tuple[dict[str, Trial], dict[str, int]]:
    """The trials that can be forked, and why others cannot -> how many; refused if none can."""
    forked, left = dict[str, Trial](), Counter[str]()
    for trial in chosen.values():
        if trial.ending == "error":
            left["ended as an error"] += 1
        elif spec_kind(trial.agent) in (PEOPLE, MCP):
            left["of people or clients, who cannot be asked again"] += 1
        elif any(fork_steps(trial, rule) for rule in at):
            forked[trial.key] = trial
        else:
            left["without such a step"] += 1
    if not forked:
        longest = max((len(trial.steps) for trial in chosen.values()), default=0) - 1
        why = f" ({', '.join(left)})" if left else ""
        expected = f"a place after which a trial goes on: after steps 1 to {longest} of the longest one here{why}"
        if longest < 1:
            expected = "a study with a trial of two steps or more: no other can be forked"
        raise BadValue("at", ", ".join(at), expected)
    return forked, dict(left)
