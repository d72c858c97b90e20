"""Trials that follow other trials: what they are told depends on what an agent did, or misread, there.

``yoked?how=looping`` tells as many false reports as the same agent had under ``flip?while=looping``;
``yoked?claims=…`` repeats the misreadings of another trial one by one; ``flip?like=…`` flips reports at the rates at
which an agent misread them in all trials of a condition. Such a trial is played after its source and takes from the
record what it needs.

A yoked control can still differ from its source by chance alone (Church, Psychological Review 71, 1964).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.confusion import Rates, entries_of, rates_of
from lockprobe.interventions.misread_flip import MisreadFlip
from lockprobe.interventions.replayed import NOTHING, Misreading, Replayed, misreading_entry
from lockprobe.interventions.sources import follows, looping_rate, looping_source, source_named
from lockprobe.interventions.yoked import Yoked
from lockprobe.statistics.confusion import Confusion, confusion
from lockprobe.statistics.misinterpretation import claims
from lockprobe.studies.modality import is_pictured, refuse_blind
from lockprobe.studies.running.other_study import OtherStudy, digest_of
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Fact, Trial
from lockprobe.trial.told_outcome import false_reports

__all__ = ["Followers", "as_recorded", "check_sources"]


def check_sources(study: Study) -> None:
    """Refuse conditions whose source is missing, follows others itself, or is not played by an agent.

    Raises:
        BadValue: If there is one.
    """
    for one in study.conditions:
        rates = [rate for spec in one.specs if (rate := looping_rate(spec)) is not None]
        if rates and looping_source(one, study.conditions) is None:
            needed = f"with the condition flip?p={rates[0]:g}&while=looping in the same study, whose trials it follows"
            raise BadValue("condition", one.label, needed)
        if follows(one):
            _check_filled(one)
        for source in filter(None, map(source_named, one.specs)):
            _check_source(study, one, source)


def _check_filled(condition: Condition) -> None:
    """Refuse what somebody wrote into a spec although a study fills it in."""
    for one in interventions_in(condition):
        for field in (*_FILLED.get(type(one).__name__, ()), *_FILLED_FIRST.get(type(one).__name__, ())):
            if getattr(one, field):
                raise BadValue("condition", condition.label, f"one without {field}, which the study fills in")


def _check_source(study: Study, follower: Condition, source: str) -> None:
    found = next((one for one in study.conditions if one.label == source), None)
    if found is None:
        if "/" not in source:
            labels = ", ".join(one.label for one in study.conditions if not follows(one))
            raise BadValue("condition", follower.label, f"a source that the study has ({labels}), or STUDY/CONDITION")
        return
    if any("of" in Spec.parse(spec).options for spec in follower.specs if source_named(spec) == source):
        raise BadValue("of", follower.label, "none with a source in the same study: every agent follows itself")
    if not study.assessment:
        raise BadValue("assessment", False, f"true with {follower.label}, which follows what agents say they did")
    if follows(found):
        raise BadValue("condition", follower.label, f"another source than {source}, which follows other trials itself")
    for agent in study.agents:
        if follower in (own := study.conditions_of(agent)) and found not in own:
            if is_pictured(found.modality) and found.modality not in study.modalities_of(agent):
                refuse_blind(agent, found.modality, "words alone")
            looks = f"agents that play {source}, whose trials {follower.label} follows; not {study.label_of(agent)}"
            raise BadValue("agent", study.label_of(agent), looks)


class Followers:
    """Fills in what the trials of a study take from other trials.

    Args:
        study: The study.
        trials: Its recorded trials, by key.
    """

    def __init__(self, study: Study, trials: Mapping[str, Trial]) -> None:
        self._study, self._trials = study, trials
        self._confusions: dict[tuple[str, str], Confusion | None] = {}
        self._others: dict[tuple[str, str], dict[tuple[int, int], Trial]] = {}

    @cached_property
    def _labels(self) -> Mapping[str, Condition]:
        return {one.label: one for one in self._study.conditions}

    def bound(self, plan: Plan) -> Plan | None:
        """The plan with what its trial takes from other trials; None as long as one of these is owed.

        Args:
            plan: Of a condition that follows others; any other stays as it is, and so does a fork: the record of its
                parent says what it took.

        Raises:
            BadFile: If another study that it follows has changed.
        """
        if plan.fork is not None or not follows(plan.condition):
            return plan
        made = [self._filled(one, plan) for one in interventions_in(plan.condition)]
        return None if None in made else _acting(plan, [one for one in made if one is not None])

    def of_record(self, plan: Plan, trial: Trial) -> Plan:
        """The plan of a trial on record: what it took from this study is taken anew, the rest as its record says."""
        acting = interventions_in(plan.condition) if follows(plan.condition) else ()
        if any(isinstance(one, Replayed) and one.claims not in self._labels for one in acting):
            return as_recorded(plan, trial)
        return self.bound(plan) or plan

    def _filled(self, one: Intervention, plan: Plan) -> Intervention | None:
        if isinstance(one, Yoked) and one.how == "looping":
            source = looping_source(plan.condition, self._study.conditions)
            assert source is not None  # a study has it
            followed = self._recorded(source, plan)
            if followed is None:
                return None
            return replace(one, at=_at_random(plan, followed, sum(false_reports(followed))))
        if isinstance(one, Replayed):
            followed = self._source_trial(one, plan)
            return None if followed is None else _replayed(one, plan, followed)
        if isinstance(one, MisreadFlip):
            return self._misread_flip(one, plan)
        return one

    def _recorded(self, condition: Condition, plan: Plan) -> Trial | None:
        """The trial of the same agent and luck under another condition; None as long as it is owed."""
        found = self._trials.get(self._study.plan(plan.agent, condition, plan.repetition, plan.trial).key)
        return None if found is None or found.owed_again else found

    def _source_trial(self, one: Replayed, plan: Plan) -> Trial | None:
        if (condition := self._labels.get(one.claims)) is not None:
            return self._recorded(condition, plan)
        return self._elsewhere(one, plan.group)[plan.repetition, plan.trial]

    def _elsewhere(self, one: Replayed, playing: str) -> dict[tuple[int, int], Trial]:
        """The trials of another study that trials of an agent follow, by repetition and trial.

        Raises:
            BadFile: If its misreadings are no longer those with which this study began.
        """
        if (found := self._others.get((one.claims, playing))) is None:
            other = OtherStudy.open(one.claims)
            if digest_of([trial for trial in other.trials if not one.of or trial.group == one.of]) != one.digest:
                raise BadFile(Path(other.directory), "its misreadings have changed since this study began")
            found = {(trial.repetition, trial.trial): trial for trial in other.of_agent(one.of, playing)}
            self._others[one.claims, playing] = found
        return found

    def _misread_flip(self, one: MisreadFlip, plan: Plan) -> MisreadFlip | None:
        if one.rates:
            return replace(one, by_label=_labelled(plan, rates_of(one.rates)))
        source = plan.agent, one.like
        if source not in self._confusions:
            condition = self._labels[one.like]
            plans = (found for found in self._study.plans(plan.agent) if found.condition == condition)
            played = [self._recorded(condition, found) for found in plans]
            ended = [trial for trial in played if trial is not None]
            self._confusions[source] = confusion(ended) if len(ended) == len(played) else None
        if (found := self._confusions[source]) is None:
            return None
        return replace(one, by_label=_labelled(plan, found.rates(one.by)), size=found.claims)


def _labelled(plan: Plan, rates: Rates) -> tuple[str, ...]:
    """Rates by joint as entries by label; a joint without a rate has none."""
    labels = Names(plan).labels
    return entries_of({label: rates.get(name, (0.0, 0.0)) for name, label in zip(plan.box.names, labels, strict=True)})


def _replayed(one: Replayed, plan: Plan, followed: Trial) -> Replayed:
    """The intervention with the misreadings of its source trial: claims that contradict what happened."""
    found = [claim for claim in claims(followed) if claim.false_belief]
    if one.how == "shuffle":
        return replace(one, at=_at_random(plan, followed, len(found)))
    labels = dict(zip(plan.box.names, Names(plan).labels, strict=True))
    entries = [
        misreading_entry(Misreading(claim.step, labels[followed.steps[claim.step - 1].joint], claim.truth))
        for claim in found
    ]
    return replace(one, misread=tuple(entries) or NOTHING)


def _at_random(plan: Plan, followed: Trial, false: int) -> tuple[int, ...]:
    """Random steps for as many false reports, of as many steps as the source trial had; 0 alone stands for none."""
    steps = max(0, len(followed.steps) - 1)  # nobody acts on the last report
    drawn = plan.stream("yoked").permutation(steps)[:false] + 1
    return tuple(sorted(drawn.tolist())) or (0,)


_FILLED: Mapping[str, tuple[str, ...]] = {
    "Yoked": ("at",),
    "Replayed": ("misread", "at"),
    "MisreadFlip": ("by_label", "size"),
}
"""Class -> the fields that a study fills in for each trial."""

_FILLED_FIRST: Mapping[str, tuple[str, ...]] = {"Replayed": ("digest",), "MisreadFlip": ("rates",)}
"""Class -> the fields that it fills in for all, from another study."""


def as_recorded(plan: Plan, trial: Trial) -> Plan:
    """The plan with what its own record says that it took from other trials."""
    if not follows(plan.condition):
        return plan
    channels = iter(trial.channels)
    return _acting(plan, [_as_recorded(one, channels) for one in interventions_in(plan.condition)])


def _as_recorded(one: Any, channels: Iterator[Mapping[str, Fact]]) -> Any:
    """An intervention, with what the next record of its class says that was filled in."""
    kind = type(one).__name__
    if kind not in _FILLED:
        return one
    found = next(channel for channel in channels if channel.get("channel") == kind)
    return replace(one, **{name: _value(found[name]) for name in _FILLED[kind]})


def _value(fact: object) -> object:
    """A field as its record has it: a whole number, or several words or numbers with semicolons between."""
    words = [word for word in str(fact).split(";") if word]
    if isinstance(fact, int):
        return fact
    return tuple(int(word) if word.isdecimal() else word for word in words)


def _acting(plan: Plan, interventions: Sequence[Intervention]) -> Plan:
    return replace(plan, condition=replace(plan.condition, interventions=tuple(interventions)))
