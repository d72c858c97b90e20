"""From an opened study to its numbers: what sections of a report make their rows from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.left_out import collecting, section
from lockprobe.foundation.parallel import Each
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose.robot import broken_said
from lockprobe.report.prose.section_answers import section_answers
from lockprobe.report.rows import Curve, Estimate, Finding
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.clustered import ClusteredProportion
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.conditions.condition_study import ConditionStudySummary, dose_series, summarise_conditions
from lockprobe.statistics.conditions.series import Series
from lockprobe.statistics.course import Course, courses
from lockprobe.statistics.dose_courses import dose_courses
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.summary import StudySummary, check_trials, summarise
from lockprobe.studies.file_names import RECORDS
from lockprobe.studies.stopping import Answer, answers_by_agent
from lockprobe.studies.study import Study
from lockprobe.studies.study_design import design_of
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import Trial


@dataclass(frozen=True, kw_only=True)
class PlayedCell:
    """One agent under one condition, with its trials and numbers.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        condition: Name of the condition.
        doses: The doses of the condition.
        summary: Its numbers.
        trials: Its trials, by repetition and trial, broken ones too.
        player: The numbers of the agent over the flip axis, if the condition is on it.
        order: The order of its blocks, if what is said of it must hold at every look.
    """

    agent: str
    modality: str
    condition: str
    doses: dict[str, float]
    summary: ConditionSummary
    trials: tuple[Trial, ...]
    player: AgentSummary | None
    order: BlockOrder | None = None

    def estimate(self, quantity: str, value: float | None = None, **columns: Any) -> Estimate:
        """A row of this cell."""
        return Estimate(quantity=quantity, value=value, **self.of, **columns)

    def share(self, quantity: str, found: Proportion | ClusteredProportion, **columns: Any) -> list[Estimate]:
        """The row of a share of this cell; none if it is a share of nothing."""
        return share_rows(quantity, found, **self.of, **columns)

    def curve(self, quantity: str, **columns: Any) -> Curve:
        """A curve of this cell."""
        return Curve(quantity=quantity, **self.of, **columns)

    @cached_property
    def ended(self) -> Outcomes:
        """Those of its trials that ended as solved or out of budget."""
        return outcomes(self.trials, order=self.order)

    @cached_property
    def broke(self) -> Outcomes:
        """Those of its trials that broke."""
        return broken_off(self.trials, order=self.order)

    @property
    def of(self) -> dict[str, Any]:
        """The columns that say of which cell a row is."""
        return {
            "agent": self.agent,
            "modality": self.modality,
            "condition": self.condition,
            "doses": self.doses,
        }


BOUNDS = ("at least", "at most")
"""Parts of a share or a difference of trials some of which broke: what it is at least and at most, whatever became of
these."""


def share_rows(quantity: str, found: Proportion | ClusteredProportion, **columns: Any) -> list[Estimate]:
    """The row of a share with its interval; none if it is a share of nothing."""
    if not found.n:
        return []
    clusters = {} if isinstance(found, Proportion) else {"clusters": found.clusters}
    row = {"value": found.value, "low": found.low, "high": found.high, "n": found.n, "count": found.count}
    return [Estimate(quantity=quantity, **row | clusters | columns)]


def of_blocks(found: BlockMean) -> dict[str, Any]:
    """The columns of a mean over blocks."""
    counted = {"n": found.pairs, "clusters": found.blocks}
    return counted | {name: getattr(found, name) for name in ("value", "low", "high", "p_value")}


@dataclass(frozen=True, kw_only=True)
class StudyNumbers:
    """All numbers of a study, without sentences.

    Attributes:
        opened: The study and its trials.
        flips: The numbers over its flip rates, the truth among them.
        others: Those of its other conditions; None without any.
        doses: Those over every other dose, and over options of agents.
    """

    opened: OpenedStudy
    flips: StudySummary
    others: ConditionStudySummary | None = None
    doses: tuple[tuple[Series, StudySummary], ...] = ()

    @property
    def study(self) -> Study:
        """The settings of the study."""
        return self.opened.study

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Those of its trials that numbers are of, by agent and condition."""
        return self.opened.analysed

    @cached_property
    def cells(self) -> tuple[PlayedCell, ...]:
        """Every agent under every condition that has trials, in the order of the study; flip rates ascend."""
        own = grouped(self.trials, lambda trial: (trial.group, trial.condition))
        players = {(one.agent, one.name): agent for agent in self.flips.agents for one in agent.conditions}
        found = {(one.agent, one.name): one for one in self.flips.conditions}
        order = list(found)
        if self.others is not None:
            found |= {name: one for name, one in self.others.conditions.items() if name not in found}
            order = [name for name in product(self.study.labels, self.conditions) if name in found]
        return tuple(
            PlayedCell(
                agent=agent,
                modality=found[agent, label].modality,
                condition=label,
                doses=dict(self.conditions[label].doses),
                summary=found[agent, label],
                trials=tuple(own.get((agent, label), ())),
                player=players.get((agent, label)),
                order=self.opened.orders.get(agent),
            )
            for agent, label in order
        )

    @cached_property
    def courses(self) -> tuple[Course, ...]:
        """Every agent over the flip rates, the truth among them; baselines too."""
        return courses(self.opened.flip_trials, orders=self.opened.orders)

    @cached_property
    def dose_courses(self) -> tuple[Course, ...]:
        """Every agent over every other dose, and over options of agents; baselines too."""
        return tuple(dose_courses(self.trials, design_of(self.study), self.opened.orders))

    @cached_property
    def conditions(self) -> Mapping[str, Condition]:
        """The conditions of the study by name, in its order."""
        return {one.label: one for one in self.study.conditions}

    @cached_property
    def series(self) -> tuple[tuple[int, Series, StudySummary], ...]:
        """The numbers over every dose but plain flip rates, and which it is of several doses of its name."""
        known, found = Counter[tuple[str, str, str, str, str]](), []
        for series, summary in self.doses:
            axis = series.axis
            place = axis.name, axis.options, axis.rest, series.modality, series.agent
            known[place] += 1
            found.append((known[place], series, summary))
        return tuple(found)

    @property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about."""
        own = tuple(dict.fromkeys(agent.agent for agent in self.flips.subjects))
        return own or (self.others.subjects if self.others else ())

    @cached_property
    def decisions(self) -> Mapping[str, tuple[Answer, ...]]:
        """Agent -> what is decided, of a study that stops when it is; empty for others."""
        return answers_by_agent(self.study, self.opened.trials) if self.study.until else {}

    @cached_property
    def _answers(self) -> dict[str, str]:
        return section_answers(self.flips)

    def answer(self, name: str, *rests_on: str) -> Iterator[Finding]:
        """The answer in the heading of a section, where it has one, and the quantities that it rests on."""
        if said := self._answers.get(name):
            yield Finding(section=name, kind="answer", text=said, rests_on=rests_on)

    @cached_property
    def all_broken(self) -> dict[str, int]:
        """The agents of which no trial ended but as an error -> how many did."""
        own = grouped(self.trials, lambda trial: trial.group)
        return {agent: len(found) for agent, found in own.items() if all(trial.error is not None for trial in found)}

    @cached_property
    def broken_rules(self) -> str:
        """How many attempts broke the rules of the box, in few words; empty if none did."""
        return broken_said(self.trials, self.study.box)


def study_numbers(opened: OpenedStudy, *, each: Each = map) -> StudyNumbers:
    """Compute all numbers of a study.

    Args:
        opened: The study.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    flips = _of_flips(opened, collecting(each))
    others, design, every = _of_others(opened, flips, collecting(each)), design_of(opened.study), collecting(each)
    doses = (
        others.series
        if others
        else dose_series(opened.analysed, design, box=opened.study.box, each=every, orders=opened.orders)
    )
    return StudyNumbers(
        opened=opened,
        flips=flips,
        others=others,
        doses=tuple(doses),
    )


def _of_flips(opened: OpenedStudy, each: Each) -> StudySummary:
    """The numbers over the flip rates; those of no trial if none can be computed."""
    study, trials = opened.study, opened.flip_trials
    try:
        check_trials(trials, study.box)
    except BadValue as error:
        raise BadFile(opened.directory / RECORDS, str(error)) from error
    return section(
        "All numbers of trials",
        lambda: summarise(trials, study.box, each=each, orders=opened.orders),
        lambda: summarise((), study.box, each=each),
    )


def _of_others(opened: OpenedStudy, flips: StudySummary, each: Each) -> ConditionStudySummary | None:
    """The numbers of conditions that are no flip rates; those of no trial if none can be computed."""
    study = opened.study
    if study.of_flips:
        return None

    def of(trials: Sequence[Trial]) -> ConditionStudySummary:
        return summarise_conditions(
            trials,
            design_of(study),
            flips,
            box=study.box,
            budget=study.max_steps,
            each=each,
            orders=opened.orders,
        )

    return section("All numbers of conditions", lambda: of(opened.analysed), lambda: of(()))
