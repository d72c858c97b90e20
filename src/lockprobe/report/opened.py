"""A study directory read once: its settings, its trials, and what its questions make their rows from.

Trials stand by agent and condition (cells), and by agent over the doses of an axis (courses).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from os.path import lexists
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lockprobe.report.prose import rules_broken_said
from lockprobe.report.rows import DoseAxis, Estimate, EveryLook, Player, Progress, Row, share_rows
from lockprobe.statistics.contrast import acting
from lockprobe.statistics.course import Cell, Course, cells_of, courses, is_baseline
from lockprobe.statistics.design import Axis, Design
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.rules import Rules
from lockprobe.studies import PEOPLE_DIRECTORY
from lockprobe.studies.branch import read_forks
from lockprobe.studies.decisions import Decision, answers_by_agent, block_orders, broken_by_agent, counted, planned_now
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import played, replaced_records
from lockprobe.studies.records.store import holds, read, trials_in
from lockprobe.studies.study import Study, design_of
from lockprobe.trial.record import Trial

if TYPE_CHECKING:
    from lockprobe.people.diary import Diary


class PlayedCell(Cell):
    """An agent under a condition, with the rows that are of it."""

    def estimate(self, quantity: str, value: float | None = None, **columns: Any) -> Estimate:
        """A row of this cell."""
        return Estimate(quantity=quantity, value=value, **self.of, **columns)

    def share(self, quantity: str, found: Proportion, **columns: Any) -> list[Estimate]:
        """The row of a share of this cell; none if it is a share of nothing."""
        return share_rows(quantity, found, **self.of, **columns)


def players_of(found: Sequence[Course], *, doses: bool = False) -> list[Player]:
    """The agents of an axis; those that are no baselines are its subjects, or all if all are."""
    subjects = [one for one in found if not one.baseline] or found
    own = ("agent", "modality", "shown", "blind", *["doses"] * doses)
    return [Player(subject=one in subjects, **{name: getattr(one, name) for name in own}) for one in found]


@dataclass(frozen=True, kw_only=True)
class OpenedStudy:
    """What a study directory holds, which everything in a report is computed from.

    Attributes:
        directory: The directory, for messages.
        study: The same as a study.
        trials: All without their words, by agent in the order of the settings, then by condition.
        results_hash: The hash of their records.
        replaced: Number of records of trials that were played again after an error.
        diaries: What participants did, in the order in which they joined.
        withdrawn: Number of participants who withdrew.
        forks: Forks of these trials on record (``lockprobe branch``).
        measured: What installed packages measure, if it is given instead of measured; None otherwise.
    """

    directory: Path
    study: Study
    trials: tuple[Trial, ...]
    results_hash: str
    replaced: int
    diaries: tuple[Diary, ...]
    withdrawn: int
    forks: tuple[Trial, ...] = ()
    measured: Sequence[Row] | None = None

    def records(self, trials: Iterable[Trial]) -> Iterator[Trial]:
        """The records of these trials, words and all, one after the other."""
        with read(self.directory) as store:
            for trial in trials:
                yield from trials_in(store, "current and key = ?", trial.key)

    @cached_property
    def every_look(self) -> EveryLook:
        """Why what is said of its trials must hold at every look; empty if all of a fixed number are played."""
        if self.study.until is not None:
            return "until"
        if self.study.earlier:
            return "extended"
        run = self.study.places_filled([trial for trial in self.trials if not trial.player])
        run += sum(broken_by_agent(self.study, self.trials).values())
        return "unfinished" if run < self.study.size - self.study.invited else ""

    @cached_property
    def analysed(self) -> tuple[Trial, ...]:
        """Those that numbers are of: without those behind an open block if the study is judged at every look."""
        return tuple(counted(self.study, self.trials)) if self.every_look else self.trials

    @cached_property
    def progress(self) -> Progress:
        """How far the study has come: places of the plan whose trial is not owed; two people in one place fill one."""
        return Progress(
            planned=planned_now(self.study, self.trials),
            finished=self.study.places_filled(self.trials),
            every_look=self.every_look,
            not_counted=len(self.trials) - len(self.analysed),
            broken=broken_by_agent(self.study, self.trials),
        )

    @property
    def finished_by_people(self) -> int:
        """Of the finished places those of people."""
        return self.study.places_filled([trial for trial in self.trials if trial.player])

    @cached_property
    def design(self) -> Design:
        """What differs between its conditions."""
        return design_of(self.study)

    @cached_property
    def by_name(self) -> Mapping[tuple[str, str], PlayedCell]:
        """Every agent under every condition that has trials, as contrasts take them."""
        made = cells_of(self.analysed, block_orders(self.study) if self.every_look else {})
        return {at: PlayedCell(**vars(one)) for at, one in made.items()}

    @cached_property
    def cells(self) -> tuple[PlayedCell, ...]:
        """The same: flip rates by course, ascending, then in plan order."""
        plan: Iterable[tuple[str, str]] = product(self.study.labels, (one.label for one in self.study.conditions))
        if self.study.of_flips:
            plan = ((one.agent, cell.condition) for one in self.courses for cell in one.cells)
        return tuple(self.by_name[place] for place in plan if place in self.by_name)

    @cached_property
    def courses(self) -> tuple[Course, ...]:
        """Every agent over the flip rates, the truth among them; baselines too."""
        return courses(cell for cell in self.by_name.values() if cell.condition in self.design.axis)

    @cached_property
    def axes(self) -> tuple[tuple[DoseAxis, tuple[Course, ...]], ...]:
        """Every other dose, with the agents over it. What changed nothing is on none."""
        times, found = Counter(self.design.series), []
        acted = acting(self.by_name, self.design, wholly=True)
        for axis in self.design.series:

            def place(cell: Cell, axis: Axis = axis) -> tuple[str, str, float] | None:
                dose = axis.doses.get(cell.condition)
                idle = dose and (cell.agent, cell.condition) not in acted
                return None if dose is None or idle else (cell.agent, axis.modality, dose)

            if over := courses(self.by_name.values(), axis, place, several=times[axis] > 1):
                found.append((DoseAxis(axis=axis, players=tuple(players_of(over, doses=True))), over))
        return tuple(found)

    @property
    def every_course(self) -> tuple[Course, ...]:
        """Every agent over flip rates and over every other dose; baselines too."""
        return (*self.courses, *(one for _, over in self.axes for one in over))

    @cached_property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about: those that are no baselines, or all if all are."""
        specs = dict(zip(self.study.labels, self.study.agents, strict=True))
        played = dict.fromkeys(one.agent for one in self.courses) or specs
        return tuple(agent for agent in played if not is_baseline(specs.get(agent, agent))) or tuple(played)

    @cached_property
    def rules(self) -> Rules:
        """The rules of its boxes."""
        return Rules(*self.study.boxes)

    @cached_property
    def broken_rules(self) -> Mapping[tuple[str, str], tuple[int, int]]:
        """Agent and condition -> attempts that broke the rules of the box, and of how many."""
        return {(cell.agent, cell.condition): self.rules.broken(cell.trials) for cell in self.cells}

    @cached_property
    def broken_rules_said(self) -> str:
        """The same of all trials, in few words; empty if none did."""
        return rules_broken_said(*map(sum, zip(*self.broken_rules.values(), strict=True)))

    @cached_property
    def decisions(self) -> Mapping[str, tuple[Decision, ...]]:
        """Agent -> what is decided, of a study that stops when it is; empty for others."""
        return answers_by_agent(self.study, self.trials) if self.study.until else {}


def open_study(directory: Path) -> OpenedStudy:
    """Read a study directory.

    Raises:
        BadFile: If it is not that of a study, or a record or a participant's diary is damaged.
    """
    diaries, gone = list["Diary"](), 0
    if lexists(directory / PEOPLE_DIRECTORY) or holds(directory, "act"):
        from lockprobe.people.diary import read_diaries  # with every act of a person, which few studies have
        from lockprobe.people.withdrawal import withdrawn

        diaries, gone = read_diaries(directory), withdrawn(directory)
    study = read_study(directory)
    trials, hashed = played(directory, study)
    return OpenedStudy(
        directory=directory,
        study=study,
        trials=tuple(sorted(trials, key=study.place_of)),
        results_hash=hashed,
        replaced=len(replaced_records(directory)),
        diaries=tuple(diaries),
        withdrawn=gone,
        forks=tuple(read_forks(directory)),
    )
