"""A study directory as the numbers of ``results.json``, which depend on what is on record and on no clock here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from itertools import chain, product
from pathlib import Path
from typing import Any

from lockprobe.analysis.response_times import ResponseTimes, response_times
from lockprobe.analysis.summary import Each, StudySummary, summarise
from lockprobe.audit.rates import shipped
from lockprobe.errors import BadFile, BadValue
from lockprobe.people.progress import Flow, flow_of
from lockprobe.people.step_times import times_of_steps
from lockprobe.prose.agent_comparison import comparison_said, ranking_said
from lockprobe.prose.hypothesis_tests import conclusions
from lockprobe.prose.loops import loop_finding
from lockprobe.prose.modalities import modality_finding
from lockprobe.prose.panel import panel_said
from lockprobe.prose.robot import verdicts_said
from lockprobe.prose.subject import subject_of
from lockprobe.prose.success import baselines_said, courses_said, finding
from lockprobe.record import Fact, Trial
from lockprobe.report.claims import claim_rows
from lockprobe.report.details import AuditedRate, AuditResult, BrokenTrials, LeftOutResult
from lockprobe.report.examples import examples
from lockprobe.report.excursions import lie_rows
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.leaderboard import comparison_rows, interaction_rows, leaderboard_rows
from lockprobe.report.people import people_row
from lockprobe.report.rows import (
    claim_row,
    condition_row,
    contrast_row,
    course_row,
    detector_row,
    fit_row,
    judged,
    modality_row,
    pace_row,
    rationality_rows,
    test_rows,
)
from lockprobe.report.sample_pictures import seen
from lockprobe.report.schema import Results, StudyProgress
from lockprobe.studies.directory import read_settings
from lockprobe.studies.records import LeftOut, read_records
from lockprobe.studies.settings import read_study

__all__ = [
    "RESULTS_VERSION",
    "LoadedStudy",
    "agent_facts",
    "audit_result",
    "broken_rows",
    "flip_results",
    "left_out_row",
    "plant_facts",
    "read",
]

RESULTS_VERSION = 3
"""Version of the layout of ``results.json``."""


MANY = 8
"""Values of a fact beyond which they are counted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadedStudy:
    """What a directory holds.

    Attributes:
        settings: As in ``study.json``.
        trials: By agent in the order of the settings, then by condition.
        summary: Their numbers.
        planned: Trials that the settings ask for, but for those of people.
        invited: Trials that they ask of people.
        journal: What the journal leaves out.
        foreign: Trials on record that the settings do not ask for; they are in no other number.
        flow: Who of people came to the end; None where nobody has taken part.
        times: How long people took for a choice.
        panel: What its pictures show of the panel, in words; empty where it has none.
    """

    settings: Mapping[str, Any]
    trials: tuple[Trial, ...]
    summary: StudySummary
    planned: int
    invited: int
    journal: LeftOut
    foreign: int
    flow: Flow | None = None
    times: tuple[ResponseTimes, ...] = ()
    panel: str = ""

    @property
    def finished(self) -> int:
        """Trials that are not owed (any more), but for those of people."""
        return sum(not trial.owed_again for trial in self.trials) - self.played_by_people

    @property
    def played_by_people(self) -> int:
        """Trials of people that are finished."""
        return sum(not trial.owed_again for trial in self.trials if trial.player)

    @property
    def partial(self) -> bool:
        """Whether trials are still owed; those of people are not, since nobody can make them come."""
        return self.finished < self.planned


def read(directory: Path | str, *, tell: Callable[[str], None] = lambda said: None, each: Each = map) -> LoadedStudy:
    """Read and summarise a study directory.

    Args:
        directory: The directory of a study.
        tell: Told what it is at, since it takes some seconds.
        each: Works on one agent after the other, or on several at once.

    Raises:
        BadFile: If it is not that of a study, holds trials of another box, or what people did is damaged.
    """
    study = read_study(directory)
    everything, left_out = read_records(directory)
    asked = [trial for trial in everything if study.asks_for(trial)]
    agents, modalities = study.agents, study.modalities
    place = {both: i for i, both in enumerate(product(agents, modalities))}
    trials = sorted(asked, key=lambda t: (place[t.group, t.modality], t.p, t.repetition, t.trial))
    tell(f"testing {len(trials)} trial{'s' * (len(trials) != 1)}")
    try:
        summary = summarise(trials, study.box, each=each)
    except BadValue as error:
        raise BadFile(Path(directory) / "trials.jsonl", str(error)) from error
    return LoadedStudy(
        settings=read_settings(directory),
        trials=tuple(trials),
        summary=summary,
        planned=study.size - study.invited,
        invited=study.invited,
        journal=left_out,
        foreign=len(everything) - len(asked),
        flow=flow_of(Path(directory)),
        times=response_times(trials, times_of_steps(Path(directory), trials)),
        panel=panel_said(study.box, dealt=study.layout == "shuffled", listed_anew=study.shuffle)
        if study.has_pictures
        else "",
    )


def flip_results(study: LoadedStudy) -> Results:
    """The results of a study of flips, and all that its pages are made from."""
    summary, agents = study.summary, study.summary.agents
    names = {(agent.agent, agent.modality): agent.name for agent in agents}
    return Results(
        schema_version=RESULTS_VERSION,
        lockprobe=version("lockprobe"),
        study=dict(study.settings),
        joints=len(study.settings.get("box", {}).get("joints", [])),
        progress=StudyProgress(planned=study.planned, finished=study.finished, partial=study.partial),
        left_out=left_out_row(study.trials, study.journal, study.foreign),
        panel_said=study.panel,
        modality_findings=[modality_finding(effect, summary) for effect in summary.modalities],
        findings=[finding(agent) for agent in summary.subjects],
        loop_findings=[loop_finding(agent) for agent in summary.subjects],
        conclusions=[conclusions(agent) for agent in summary.subjects],
        ranking_said=ranking_said(summary),
        comparisons_said=[comparison_said(one, summary) for one in summary.comparisons],
        beside=baselines_said(summary),
        courses_said=courses_said(summary),
        box=summary.reference,
        conditions=[condition_row(c, a.name, blind=a.blind) for a in agents for c in a.conditions],
        leaderboard=leaderboard_rows(summary, study.trials),
        comparisons=comparison_rows(summary.comparisons, names),
        interactions=interaction_rows(summary.comparisons, names),
        rationality=[row for a in agents for c in a.conditions for row in rationality_rows(c, a.name, blind=a.blind)],
        judged=judged(summary),
        lies=lie_rows(study.trials, [(a.agent, a.modality, subject_of(a)) for a in summary.subjects if not a.blind]),
        paces=[pace_row(compared, names) for compared in summary.paces],
        modalities=[modality_row(effect) for effect in summary.modalities],
        people=people_row(summary, study.invited, study.played_by_people, study.flow, study.times),
        verdicts=summary.verdicts,
        verdicts_said=verdicts_said(summary.verdicts) if summary.verdicts else "",
        fits=[fit_row(agent) for agent in agents],
        tests=[row for agent in agents if not agent.blind for row in test_rows(agent)],
        contrasts=[contrast_row(agent, agent.contrast) for agent in agents if agent.contrast],
        courses=[row for agent in agents if (row := course_row(agent))],
        claims=[claim_row(row) for row in claim_rows(summary)],
        detectors=[
            detector_row(condition, study.trials, agent.name)
            for agent in summary.subjects
            for condition in agent.conditions
            if condition.success.n
        ],
        examples=examples(summary, study.trials),
        measures=measure_rows(study.trials),
        errors=broken_rows(study.trials),
        agents=agent_facts(study.trials),
        plants=plant_facts(study.trials, study.settings),
        seen=seen(study.trials),
        subjects=list(dict.fromkeys(agent.agent for agent in summary.subjects)),
        audit=audit_result(),
    )


def left_out_row(trials: Sequence[Trial], journal: LeftOut, not_asked_for: int) -> LeftOutResult:
    """What is on record and in no number, and what was played twice.

    Args:
        trials: Those that the settings ask for.
        journal: What the journal leaves out.
        not_asked_for: Trials that the settings do not ask for.
    """
    return LeftOutResult(
        errors=sum(trial.ending == "error" for trial in trials),
        replayed_on_request=sum(trial.replays > 0 for trial in trials),
        replaced_after_an_error=journal.replaced,
        repeated=journal.repeated,
        unfinished_lines=journal.unfinished_lines,
        not_asked_for=not_asked_for,
        foreign=journal.foreign,
    )


def agent_facts(trials: Iterable[Trial]) -> dict[str, dict[str, str]]:
    """What every agent was, as it says itself."""
    return _facts(chain.from_iterable(_told(trial) for trial in trials))


def plant_facts(trials: Iterable[Trial], settings: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """What the plant was, as it says itself."""
    return _facts((str(settings.get("plant")), _known(trial.plant)) for trial in trials)


def _facts(told: Iterable[tuple[str, Mapping[str, Fact]]]) -> dict[str, dict[str, str]]:
    """What every agent was, or the plant; where trials differ, all values are labelled, or how many there are."""
    found: dict[str, dict[str, dict[str, None]]] = {}
    for what, facts in told:
        for name, value in facts.items():
            found.setdefault(what, {}).setdefault(name, {})[str(value)] = None
    return {
        what: {
            name: "; ".join(values) if len(values) <= MANY else f"{len(values)} different values"
            for name, values in facts.items()
        }
        for what, facts in found.items()
    }


def _told(trial: Trial) -> Iterator[tuple[str, Mapping[str, Fact]]]:
    """What the agent said it was, and which models answered in its place, as their provider names them."""
    yield trial.group, trial.facts
    for served in dict.fromkeys(step.decision.served for step in trial.steps):
        if served:
            yield trial.group, {"answered by": served}


def _known(facts: Mapping[str, Fact]) -> dict[str, Fact]:
    """Without what a plant does not have, as a renderer where nobody looks."""
    return {name: value for name, value in facts.items() if value is not None}


def broken_rows(trials: Sequence[Trial]) -> list[BrokenTrials]:
    """Broken trials by agent and boundary, with the first message, and whether they are owed again."""
    broken = [(trial, trial.error) for trial in trials if trial.error is not None]
    counts = Counter((trial.group, str(error.boundary)) for trial, error in broken)
    first = {(trial.group, str(error.boundary)): (error.message, trial.owed_again) for trial, error in reversed(broken)}
    return [
        BrokenTrials(agent=agent, boundary=boundary, trials=count, message=message, owed_again=owed_again)
        for (agent, boundary), count in sorted(counts.items())
        for message, owed_again in (first[agent, boundary],)
    ]


def audit_result() -> AuditResult:
    """The shipped audit."""
    audit = shipped()
    return AuditResult(
        seed=audit["seed"], worlds=audit["worlds"], rates=[AuditedRate(**rate) for rate in audit["rates"]]
    )
