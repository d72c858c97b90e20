"""What a study takes from another one, named by its directory: the misreadings of an agent under a condition there."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.conditions import interventions_in
from lockprobe.interventions.confusion import entries_of
from lockprobe.interventions.misread_flip import MisreadFlip
from lockprobe.interventions.replayed import Replayed
from lockprobe.interventions.sources import source_named
from lockprobe.statistics.confusion import confusion
from lockprobe.statistics.misinterpretation import claims
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Trial

__all__ = ["OtherStudy", "digest_of", "with_sources"]


@dataclass(frozen=True, slots=True)
class OtherStudy:
    """A condition of another study.

    Attributes:
        directory: The directory of the study, as it was named.
        label: The condition.
        study: The settings of the study.
        trials: Its trials under the condition.
    """

    directory: str
    label: str
    study: Study
    trials: tuple[Trial, ...]

    @classmethod
    def open(cls, source: str) -> OtherStudy:
        """Read ``STUDY/CONDITION``.

        Raises:
            BadValue: If no directory stands before the last slash.
            BadFile: If it holds no study.
            UnknownName: If the study has no trial of such a condition.
        """
        directory, _, label = source.rpartition("/")
        if not directory:
            raise BadValue("source", source, "STUDY/CONDITION, with the directory of a study before the slash")
        study, trials = read_study(directory), load(Path(directory))
        found = tuple(trial for trial in trials if trial.condition == label)
        if not found:
            known = dict.fromkeys(trial.condition for trial in trials)
            raise UnknownName(f"condition in {directory}", label, known or ["none, since no trial has ended there"])
        return cls(directory, label, study, found)

    @property
    def name(self) -> str:
        """The condition, and its study by name and hash: what records show in place of a directory."""
        return f"{self.study.name}@{self.study.identity}/{self.label}"

    def of_agent(self, of: str, playing: str = "") -> list[Trial]:
        """The trials of one agent.

        Args:
            of: What the study calls the agent; empty for the one that plays, or the only one.
            playing: The agent that plays here.

        Raises:
            BadValue: If there is no such agent, or it is not said which of several.
        """
        agents = list(dict.fromkeys(trial.group for trial in self.trials))
        chosen = of or (playing if playing in agents else agents[0] if len(agents) == 1 else "")
        if chosen not in agents:
            raise BadValue("of", chosen, f"an agent of {self.directory}: {', '.join(agents)}")
        found = [trial for trial in self.trials if trial.group == chosen]
        if not any(map(claims, found)):
            raise BadValue("source", f"{self.directory}/{self.label}", "one whose agent said what its attempts did")
        return found

    def check_box(self, study: Study, instead: str = "") -> None:
        """Refuse another box: misreadings are of joints.

        Raises:
            BadValue: If joints or interlock differ from those of the study that takes them.
        """
        theirs, own = self.study.box, study.box
        same = sorted(theirs.names) == sorted(own.names) and theirs.target == own.target
        if not same or any(theirs.alternatives(name) != own.alternatives(name) for name in own.names):
            raise BadValue("source", self.directory, f"a study of {own.name}, not of {theirs.name}{instead}")


def digest_of(trials: list[Trial]) -> str:
    """Sixteen hexadecimal digits of what an agent misread in trials, in any order."""
    lines = sorted(
        f"{trial.repetition} {trial.trial} {claim.step} {trial.steps[claim.step - 1].joint} {claim.truth}"
        for trial in trials
        for claim in claims(trial)
        if claim.false_belief
    )
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def with_sources(study: Study) -> Study:
    """A study whose conditions hold what they take from other studies: rates, or the hash of the misreadings.

    Raises:
        UserMistake: If another study cannot be read, is of another box, or has not what is taken.
    """
    conditions = tuple(_with_source(one, study) for one in study.conditions)
    return study if conditions == study.conditions else replace(study, conditions=conditions)


def _with_source(condition: Condition, study: Study) -> Condition:
    labels = {one.label for one in study.conditions}
    named = [source for spec in condition.specs if (source := source_named(spec)) and source not in labels]
    others = {source: OtherStudy.open(source) for source in named if "/" in source}
    if not others:
        return condition
    name = condition.label
    for source, other in others.items():
        name = name.replace(source, f"{other.study.name}/{other.label}")
    made = tuple(_filled(one, others, study) for one in interventions_in(condition))
    return replace(condition, interventions=made, name=name)


def _filled(one: Intervention, others: dict[str, OtherStudy], study: Study) -> Intervention:
    if isinstance(one, MisreadFlip) and (other := others.get(one.like)):
        if one.by == "joint":
            other.check_box(study, "; by=direction and by=total fit any box")
        found = confusion(other.of_agent(one.of))
        return replace(one, like=other.name, rates=entries_of(found.rates(one.by, study.box.names)), size=found.claims)
    if isinstance(one, Replayed) and (other := others.get(one.claims)):
        other.check_box(study)
        for agent in study.agents:
            _check_trials(other, other.of_agent(one.of, study.label_of(agent)), study, agent)
        return replace(one, digest=digest_of([trial for trial in other.trials if not one.of or trial.group == one.of]))
    return one


def _check_trials(other: OtherStudy, trials: list[Trial], study: Study, agent: str) -> None:
    """Refuse a source with fewer trials than are to follow them."""
    there = {(trial.repetition, trial.trial) for trial in trials}
    for repetition in range(1, study.repetitions + 1):
        for number in range(1, study.trials_of(agent) + 1):
            if (repetition, number) not in there:
                wanted = f"one with repetition {repetition}, trial {number}, which a trial of this study follows"
                raise BadValue("source", f"{other.directory}/{other.label}", wanted)
