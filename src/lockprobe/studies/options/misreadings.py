"""The rates of ``flip?like=DIR/CONDITION``, read from a finished study when a study is made."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.misread_flip import MisreadFlip, entries_of
from lockprobe.statistics.misinterpretation import claim_counts, misread_rates
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import Trial


def with_misreadings(study: Study) -> Study:
    """A study whose conditions hold the rates that they take from other studies.

    Raises:
        UserMistake: If another study cannot be read, is of another box, or has not what is taken.
    """
    return replace(study, conditions=tuple(_with_rates(one, study) for one in study.conditions))


def _with_rates(condition: Condition, study: Study) -> Condition:
    name, acting = condition.name, list(condition.interventions)
    for i, one in enumerate(acting):
        if isinstance(one, MisreadFlip) and not one.rates:
            other, label, trials = _read(one)
            unlike = any(_joints(theirs) != _joints(own) for theirs, own in product(other.boxes, study.boxes))
            if one.by == "joint" and unlike:
                expected = (
                    f"a study of {study.box.name}, not of {other.box.name}; by=direction and by=total fit any box"
                )
                raise BadValue("like", one.like, expected)
            said = claim_counts(trials)
            names = dict.fromkeys(name for box in study.boxes for name in box.names)
            rates = entries_of(misread_rates(said, [*names], one.by))
            acting[i] = replace(one, like=f"{other.name}@{other.identity}/{label}", rates=rates, size=said.total())
            name = (name or condition.spec).replace(one.like, f"{other.name}/{label}")
    changed = acting != [*condition.interventions]
    return replace(condition, interventions=tuple(acting), name=name) if changed else condition


def _joints(box: Lockbox) -> tuple[object, ...]:
    """What boxes share whose joints have the same rates: their names, the target, and what holds each."""
    return box.target, *((name, box.alternatives(name)) for name in sorted(box.names))


def _read(one: MisreadFlip) -> tuple[Study, str, list[Trial]]:
    """The study that a flip names, its condition there, and the trials of the agent."""
    directory, _, label = one.like.rpartition("/")
    if not directory:
        raise BadValue("like", one.like, "DIR/CONDITION, with the directory of a finished study")
    there = load(Path(directory))
    trials = [trial for trial in there if trial.condition == label]
    if not trials:
        known = dict.fromkeys(trial.condition for trial in there)
        raise UnknownName(f"condition in {directory}", label, known or ["none, since no trial has ended there"])
    agents = list(dict.fromkeys(trial.group for trial in trials))
    if (chosen := one.of or (agents[0] if len(agents) == 1 else "")) not in agents:
        raise BadValue("of", chosen, f"an agent of {directory}: {', '.join(agents)}")
    own = [trial for trial in trials if trial.group == chosen]
    if not claim_counts(own):
        raise BadValue("like", one.like, "a condition whose agent said what its attempts did")
    return read_study(directory), label, own
