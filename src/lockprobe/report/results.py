"""The results of a study from its numbers: every section's rows, in one table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path

from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.report.every_look import at_every_look
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.first_screen import without_answer
from lockprobe.report.rows import (
    Condition,
    Curve,
    Design,
    DoseAxis,
    Estimate,
    Finding,
    LeftOut,
    Player,
    Progress,
    Results,
    Row,
)
from lockprobe.report.section import Section
from lockprobe.report.study_numbers import StudyNumbers, study_numbers
from lockprobe.statistics.summary import StudySummary
from lockprobe.studies.records.results_hash import results_hash
from lockprobe.studies.stopping import planned_now
from lockprobe.studies.study_design import design_of


def results_of(numbers: StudyNumbers) -> Results:
    """The results of a study."""
    opened, study = numbers.opened, numbers.study
    rows, named = list[Row](), set[tuple[str, ...]]()
    for one in all_sections():
        rows += section(one.title, partial(_rows_of, one, numbers, named), list[Row])
    found = Results(
        lockprobe=version("lockprobe"),
        study=_settings(opened),
        settings_hash=study.settings_hash,
        results_hash=results_hash(study, opened.trials),
        progress=_progress(opened),
        design=_design(numbers),
    ).with_rows(_resting(at_every_look(rows) if opened.every_look else rows))
    return found.changed(answer=found.answer_of("overview"))


def _progress(opened: OpenedStudy) -> Progress:
    study, finished = opened.study, opened.finished
    return Progress(
        planned=planned_now(study, opened.trials),
        finished=finished,
        every_look=opened.every_look,
        not_counted=len(opened.trials) - len(opened.analysed),
    )


def _settings(opened: OpenedStudy) -> dict[str, object]:
    """The settings, with what pages call the agents in place of their specs, which may say more than is shown."""
    found = {name: value for name, value in opened.settings.items() if name not in ("agents", "names")}
    return {**found, "agents": list(opened.study.labels)}


def _rows_of(one: Section, numbers: StudyNumbers, named: set[tuple[str, ...]]) -> list[Row]:
    """The rows of a section.

    Args:
        one: The section.
        numbers: The numbers of the study.
        named: What there are numbers of; those of the section are added.

    Raises:
        ValueError: If a reader could not tell two numbers apart.
    """
    rows = list(one.rows(numbers))
    for row in rows:
        if isinstance(row, Estimate | Curve):
            name = (type(row).__name__, *row.identity)
            if name in named:
                raise ValueError(f"two rows are of {', '.join(filter(None, row.identity))}")
            named.add(name)
    return rows


def _resting(rows: Iterable[Row]) -> Iterator[Row]:
    """The rows, of which sentences rest on those quantities alone that there are rows of."""
    found = list(rows)
    known = {row.quantity for row in found if isinstance(row, Estimate | Curve)}
    for row in found:
        if isinstance(row, Finding):
            yield row.model_copy(update={"rests_on": tuple(name for name in row.rests_on if name in known)})
        else:
            yield row


def _design(numbers: StudyNumbers) -> Design:
    study, flips = numbers.study, numbers.flips
    design, on_axis = design_of(study), study.flip_labels
    players = _players(flips)
    known = {one.agent for one in players}
    others = [cell for cell in numbers.cells if cell.agent not in known]
    players += [
        Player(agent=agent, modality=modality, subject=agent in numbers.subjects)
        for agent, modality in dict.fromkeys((cell.agent, cell.modality) for cell in others)
    ]
    return Design(
        conditions=tuple(
            Condition(
                name=one.label,
                specs=one.specs,
                modality=one.modality,
                doses=dict(one.doses),
                p=one.p if one.label in on_axis else None,
                control=control if (control := design.control(one.label)) != one.label else "",
            )
            for one in study.conditions
        ),
        players=tuple(players),
        axes=(*_flip_axes(numbers), *_other_axes(numbers)),
        flip_kind=study.flip_kind,
    )


def _flip_axes(numbers: StudyNumbers) -> Iterator[DoseAxis]:
    """The flip rates of each modality that has several."""
    for modality in numbers.study.modalities:
        own = {one.label: one.p for one in numbers.study.flip_axis if one.modality == modality and one.p is not None}
        if len(own) > 1:
            doses = dict(sorted(own.items(), key=lambda pair: pair[1]))
            yield DoseAxis(name="flip rate", intervention="flip", dose="p", modality=modality, doses=doses)


def _other_axes(numbers: StudyNumbers) -> Iterator[DoseAxis]:
    """The doses of other interventions, and options of agents."""
    for number, series, summary in numbers.series:
        axis, first = series.axis, numbers.study.conditions[0].label
        yield DoseAxis(
            name=axis.name,
            intervention=axis.kind,
            dose=axis.dose,
            options=axis.options,
            rest=axis.rest,
            modality=series.modality,
            doses=dict(series.doses),
            condition=design_of(numbers.study).control(first) if series.agent else "",
            players=tuple(_players(summary)),
            number=number,
        )


def _players(summary: StudySummary) -> list[Player]:
    """The agents of an axis."""
    subjects = {(one.agent, one.modality) for one in summary.subjects}
    return [
        Player(
            agent=one.agent,
            modality=one.modality,
            shown=one.shown,
            subject=(one.agent, one.modality) in subjects,
            blind=one.blind,
        )
        for one in summary.agents
    ]


def with_left_out(found: Results, left_out: Sequence[LeftOutSection]) -> Results:
    """The results with the sections that could not be made; no answer stands where its numbers are among them."""
    rows = tuple(LeftOut(**one.plain()) for one in left_out)
    return without_answer(found.changed(sections_left_out=rows)) if rows else found


def results(directory: Path | str) -> Results:
    """What a study found, from its records, as a table of rows; equal records give equal results.

    Args:
        directory: The directory of a study.

    Raises:
        BadFile: If it is none.
    """
    with one_thread(), leaving_out() as left_out:
        opened = open_study(Path(directory))
        found = results_of(study_numbers(opened))
    return with_left_out(found, left_out)
