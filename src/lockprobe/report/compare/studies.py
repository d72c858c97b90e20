"""Studies side by side: success of every agent under the conditions that they share, differences, and their page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.plain_json import plain_json
from lockprobe.report.prose.robot import broken_said
from lockprobe.report.prose.study_comparison import comparison_of_studies_said
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.agent_comparison.across_studies import Sample, Side, StudyDifference, study_differences
from lockprobe.statistics.broken_trials import begun
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.proportions import Proportion
from lockprobe.studies.comparable import check_comparable, families, shared_names
from lockprobe.studies.stopping import planned_now
from lockprobe.trial.record import Trial

_VERSION = 1
"""Version of the layout of :meth:`Comparison.plain`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedStudy:
    """One study of a comparison.

    Attributes:
        name: The end of its directory's path by which it is told from the others.
        study: Name in its settings.
        seed: Studies of equal seed share their luck.
        agents: Their names, or specs of those that have none.
        planned: Trials that the settings ask for, also of people.
        finished: Of these, trials that are not owed (any more).
        people_trials: Of these, trials of people.
        not_shared: Its conditions that no other study has; they are in no number.
        looked_at: Whether it is unfinished, was extended, or stops when it is decided.
    """

    name: str
    study: str
    seed: int
    agents: tuple[str, ...]
    planned: int
    finished: int
    people_trials: int
    not_shared: tuple[str, ...]
    looked_at: bool = False

    @property
    def partial(self) -> bool:
        """Whether trials are still owed."""
        return self.finished < self.planned


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessRow:
    """One side under one condition.

    Attributes:
        side: Who played.
        condition: Name of the condition.
        success: Trials solved with Wilson's 95 % interval, of those that ended as solved or out of budget; it holds
            whatever became of those that broke.
    """

    side: Side
    condition: str
    success: Proportion


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Studies side by side.

    Attributes:
        box: Name of the box.
        studies: In the order asked for.
        said: The conclusion in a sentence.
        success: A row for each side and shared condition that has been played.
        differences: Every two sides under every condition that both have, those between studies first.
        unlike: What differs between agents of one spec in several studies, a line each.
    """

    box: str
    studies: tuple[ComparedStudy, ...]
    said: str
    success: tuple[SuccessRow, ...]
    differences: tuple[StudyDifference, ...]
    unlike: tuple[str, ...]

    @property
    def subjects(self) -> dict[Side, Subject]:
        """What sentences call each side."""
        return {row.side: _subject(row.side, self.studies) for row in self.success}

    @property
    def names(self) -> dict[Side, str]:
        """The same as text."""
        return {side: subject.name for side, subject in self.subjects.items()}

    def plain(self) -> dict[str, Any]:
        """The comparison as JSON holds it."""
        studies = [plain_json(one) | {"partial": one.partial} for one in self.studies]
        return {
            "schema_version": _VERSION,
            "lockprobe": version("lockprobe"),
            "box": self.box,
            "said": self.said,
            "studies": studies,
            "success": [
                self._named("", row.side)
                | {"condition": row.condition, "broken": row.success.broken}
                | _share("", row.success)
                for row in self.success
            ],
            "differences": [self._difference(one) for one in self.differences],
            "unlike": list(self.unlike),
        }

    def _named(self, role: str, side: Side) -> dict[str, Any]:
        return {
            f"{role}study": self.studies[side.study].name,
            f"{role}agent": side.agent,
            f"{role}prompt": side.prompt,
        }

    def _difference(self, one: StudyDifference) -> dict[str, Any]:
        found = {
            name: value
            for name, value in plain_json(one).items()
            if name not in ("first", "second", "first_success", "second_success")
        }
        return (
            self._named("first_", one.first)
            | self._named("second_", one.second)
            | found
            | _share("first_", one.first_success)
            | _share("second_", one.second_success)
            | {"verdict": one.verdict}
        )


def compare_studies(directories: Sequence[Path], agents: Sequence[str] = ()) -> Comparison:
    """Compare the studies in several directories.

    Args:
        directories: Two or more, each of another study.
        agents: Agents to compare, as pages call them; all if none are given.

    Raises:
        BadFile: If a directory is given twice or is that of no study, or if studies cannot be compared.
        BadValue: If there are fewer than two.
        UnknownName: If no study has such an agent.
    """
    _refuse_twice(directories)
    opened = {directory: open_study(directory) for directory in directories}
    check_comparable({directory: one.study for directory, one in opened.items()})
    known = dict.fromkeys(agent for one in opened.values() for agent in one.study.labels)
    for agent in agents:
        if agent not in known:
            raise UnknownName("agent of these studies", agent, known)
    shared = _shared(list(opened.values()))
    studies = tuple(
        _studied(name, one, [left.name for left in shared_names(one.study).values() if left.name not in shared])
        for name, one in zip(_names(directories), opened.values(), strict=True)
    )
    samples = _samples(list(opened.values()), shared, set(agents or known))
    found, box = study_differences(samples), next(iter(opened.values())).study.box
    broken = broken_said((trial for one in samples for trial in one.trials), box)
    said = comparison_of_studies_said(found, {one.side: _subject(one.side, studies) for one in samples})
    return Comparison(
        box=box.name,
        studies=studies,
        said=" ".join(filter(None, (said, broken))),
        success=tuple(_success(one) for one in samples),
        differences=found,
        unlike=tuple(_unlike(samples, studies)),
    )


def _refuse_twice(directories: Sequence[Path]) -> None:
    resolved = [directory.resolve() for directory in directories]
    for directory, path in zip(directories, resolved, strict=True):
        if resolved.count(path) > 1:
            raise BadFile(directory, "given twice; a study is compared with others")


def _names(directories: Sequence[Path]) -> list[str]:
    """Of each path the shortest end that tells it from the others."""
    ends = [
        ["/".join(path.parts[-n:]) for n in range(1, len(path.parts) + 1)] for path in map(Path.resolve, directories)
    ]
    return [next(end for end in own if sum(end in other for other in ends) == 1) for own in ends]


def _shared(opened: Sequence[OpenedStudy]) -> dict[str, str]:
    """The conditions that two studies or more have, each with its family, in the order of the families."""
    own = [{one.name: one for one in shared_names(study.study).values()} for study in opened]
    every = {name: one for names in own for name, one in names.items()}
    return families(one for name, one in every.items() if sum(name in names for names in own) > 1)


def _studied(name: str, one: OpenedStudy, not_shared: Sequence[str]) -> ComparedStudy:
    return ComparedStudy(
        name=name,
        study=one.study.name,
        seed=one.study.seed,
        agents=one.study.labels,
        planned=planned_now(one.study, one.trials),
        finished=one.finished,
        people_trials=one.finished_by_people,
        not_shared=tuple(dict.fromkeys(not_shared)),
        looked_at=bool(one.every_look),
    )


def _samples(opened: Sequence[OpenedStudy], shared: Mapping[str, str], agents: set[str]) -> list[Sample]:
    """The trials of every side under every shared condition, by condition; none without trials."""
    order = list(shared)
    found: dict[tuple[str, Side], list[Trial]] = {}
    for number, one in enumerate(opened):
        names = shared_names(one.study)
        for trial in one.trials:
            condition = one.study.condition_of(trial)
            own = names[condition] if condition else None
            if own and own.name in shared and trial.group in agents:
                side = Side(number, trial.group, own.prompt)
                found.setdefault((own.name, side), []).append(trial)
    return [
        Sample(
            side=side,
            condition=name,
            family=shared[name],
            luck=opened[side.study].study.seed,
            baseline=is_baseline(trials[0].spec),
            trials=trials,
        )
        for (name, side), trials in sorted(found.items(), key=lambda one: (order.index(one[0][0]), one[0][1].study))
    ]


def _subject(side: Side, studies: Sequence[ComparedStudy]) -> Subject:
    who = Subject.of(side.agent)
    prompt = f" with {side.prompt}" if side.prompt else ""
    return Subject(name=f"{who.name}{prompt} in {studies[side.study].name}", plural=who.plural)


def _success(one: Sample) -> SuccessRow:
    every, solved = begun(outcomes(one.trials), broken_off(one.trials))
    return SuccessRow(side=one.side, condition=one.condition, success=share_of(solved, every.player, every.luck))


def _share(role: str, found: Proportion) -> dict[str, Any]:
    return {
        f"{role}trials": found.n,
        f"{role}solved": found.count,
        f"{role}success": found.value if found.n else None,
        f"{role}success_low": found.low,
        f"{role}success_high": found.high,
    }


def _unlike(samples: Sequence[Sample], studies: Sequence[ComparedStudy]) -> list[str]:
    """Facts about agents of one spec that differ between studies."""
    facts: dict[str, dict[int, Mapping[str, Any]]] = {}
    called: dict[str, str] = {}
    for one in samples:
        if not one.trials[0].player:
            spec = one.trials[0].spec
            called.setdefault(spec, one.side.agent)
            facts.setdefault(spec, {}).setdefault(one.side.study, one.trials[0].facts)
    said = []
    for spec, by_study in facts.items():
        agent = called[spec]
        for fact in dict.fromkeys(name for own in by_study.values() for name in own):
            values = {studies[number].name: own.get(fact) for number, own in by_study.items()}
            if len({repr(value) for value in values.values()}) > 1:
                said.append(f"{agent}: {fact} is " + ", ".join(f"{value} in {name}" for name, value in values.items()))
    return said
