"""The scores of a suite, computed from the records of its studies: ``suite.json`` and its page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimum, random_success
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, of_whom, section
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.plain_json import plain_json
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.suite.ranks import possible_ranks
from lockprobe.statistics.suite.scores import LevelTrials, SuiteScore, suite_score
from lockprobe.studies.options import paper
from lockprobe.studies.records.results_hash import records_digest
from lockprobe.studies.stopping import due
from lockprobe.studies.suites import Suite, read_suite, suite_directories

__all__ = ["Entry", "Level", "SuiteResults", "suite_results"]

_VERSION = 1
"""Version of the layout of :meth:`SuiteResults.plain`."""


Level = dict[str, Any]
"""A level as JSON holds it: its ``box``, the number of ``joints``, the fewest steps that open it (``optimum``),
``chance``, the exact success of a uniformly random agent within the budget, and whether it is ``judged``: whether an
ideal observer judges actions on it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """An agent of a suite, shown the boxes in one way.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the boxes were shown.
        name: Its spec, and what it is shown in brackets if it looks at pictures.
        planned: Trials planned; where studies stop when they are decided, the most.
        partial: Whether trials are missing.
        scores: Its scores.
    """

    agent: str
    modality: str
    name: str
    planned: int
    partial: bool
    scores: SuiteScore


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteResults:
    """What a suite's directory holds.

    Attributes:
        suite: Which suite.
        levels: Its levels, from easy to hard.
        entries: The agents, the most competent first; those without a competence last.
        records: SHA-256 of the records of each study, in the order of their keys, by the name of its directory.
        sections_left_out: Scores, tables and figures that could not be made.
    """

    suite: Suite
    levels: Sequence[Level]
    entries: tuple[Entry, ...]
    records: dict[str, str]
    sections_left_out: tuple[LeftOutSection, ...] = ()

    def plain(self) -> dict[str, Any]:
        """As JSON holds it."""
        entries = [
            {"agent": one.agent, "modality": one.modality, "planned": one.planned, **asdict(one.scores)}
            for one in self.entries
        ]
        found: dict[str, Any] = {
            "suite": self.suite.name,
            **self.suite.stopping,
            "version": _VERSION,
            "lockprobe": version("lockprobe"),
            "levels": self.levels,
            "agents": entries,
            "records": self.records,
        }
        if self.sections_left_out:
            found["sections_left_out"] = [one.plain() for one in self.sections_left_out]
        plain: dict[str, Any] = plain_json(found)
        return plain


def suite_results(directory: Path) -> SuiteResults:
    """Compute the scores of a suite's directory from its records.

    Raises:
        BadFile: If it is not one, or a record is damaged.
    """
    suite = read_suite(directory)
    studies = {name: open_study(directory / name) for name in suite_directories(directory, suite)}
    levels = [_level(name, judged=name in suite.judged) for name in suite.boxes]
    cells = dict.fromkeys(
        (agent, modality, name.removeprefix(study.study.box.name))
        for name, study in studies.items()
        for agent in study.study.labels
        for modality in study.study.modalities
    )
    with leaving_out() as left_out:
        entries = _entries(cells, suite, levels, studies)
    entries.sort(key=lambda one: -one.scores.competence.value if one.scores.competence else 1.0)
    return SuiteResults(
        suite=suite,
        levels=levels,
        entries=tuple(entries),
        records={name: records_digest(study.trials) for name, study in studies.items()},
        sections_left_out=tuple(left_out),
    )


def _level(name: str, *, judged: bool) -> Level:
    found = box(name)
    chance = random_success(found, paper.MAX_STEPS)
    return {"box": name, "joints": len(found.joints), "optimum": optimum(found), "chance": chance, "judged": judged}


def _entries(
    cells: Iterable[tuple[str, str, str]], suite: Suite, levels: Sequence[Level], studies: Mapping[str, OpenedStudy]
) -> list[Entry]:
    """Every agent with its scores, judged together with all that have trials at every level."""
    played = {
        (agent, modality): _played(agent, modality, [(one, studies.get(f"{one['box']}{ending}")) for one in levels])
        for agent, modality, ending in cells
    }
    told = {name: [outcomes(level.told) for level in own] for name, (own, _) in played.items()}
    competing = [name for name, own in told.items() if all(map(len, own))]
    ranks = section(
        "Ranks",
        lambda: dict(zip(competing, possible_ranks([told[name] for name in competing]), strict=True)),
        dict[tuple[str, str], tuple[int, int]],
    )
    together = max(1, len(competing))
    found = []
    for (agent, modality), (own, pictures) in played.items():
        with of_whom(agent):
            scores = suite_score(own, together=together)
        if together > 1:
            scores = replace(scores, ranks=ranks.get((agent, modality)))
        planned = len(levels) * len(suite.p) * (suite.looks if pictures else suite.trials)
        name = f"{agent} ({spoken(modality)})" if pictures else agent
        partial = scores.trials + scores.broken < planned
        if suite.until is not None:
            partial = any(agent in one.study.labels and _goes_on(agent, one) for one in studies.values())
        entry = Entry(agent=agent, modality=modality, name=name, planned=planned, partial=partial, scores=scores)
        found.append(entry)
    return found


def _goes_on(agent: str, opened: OpenedStudy) -> bool:
    """Whether an agent has to play more trials of a study that stops when it is decided."""
    spec = next(one for one in opened.study.agents if opened.study.label_of(one) == agent)
    return bool(due(opened.study, spec, opened.trials))


def _played(
    agent: str, modality: str, studies: Sequence[tuple[Level, OpenedStudy | None]]
) -> tuple[list[LevelTrials], bool]:
    """The trials of an agent by level, and whether it was shown pictures."""
    found = []
    for level, opened in studies:
        own = [one for one in (opened.trials if opened else ()) if (one.group, one.modality) == (agent, modality)]
        told, misled = ([one for one in own if bool(one.p) == false] for false in (False, True))
        at = {name: level[name] for name in ("box", "chance", "judged")}
        found.append(LevelTrials(told=told, misled=misled, **at))
    return found, any(opened is not None and opened.study.has_pictures for _, opened in studies)
