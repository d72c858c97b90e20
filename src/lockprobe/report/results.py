"""The results of a study from its numbers: every section's rows, in one table."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from lockprobe.report.left_out import leaving_out, section
from lockprobe.report.opened import OpenedStudy, open_study, players_of
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.first_screen import answer_of
from lockprobe.report.rows import Condition, Design, DoseAxis, Estimate, Player, Results, Row
from lockprobe.statistics.design import FLIPS
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.studies.study import settings_of

ONE_THREAD = 1
"""Of products of matrices: the last digits of sums depend on their number, and are now the same on every machine."""

_ONE_LOOK = "its P value holds for one look, when all planned trials are played"


def results_of(numbers: OpenedStudy) -> Results:
    """The results of a study."""
    study, rows = numbers.study, list[Row]()
    for one in all_sections():
        rows += section(one.title, lambda one=one: list(one.rows(numbers)), list[Row])  # type: ignore[misc]
    if numbers.every_look:  # at a number of trials that was planned and is played, most P values hold for one look
        for i, row in enumerate(rows):
            if isinstance(row, Estimate) and row.p_value is not None and E_PROCESS not in row.test:
                note = "; ".join(filter(None, (row.note, _ONE_LOOK)))
                rows[i] = row.model_copy(update={"p_value": None, "test": "", "note": note})
    settings = {name: value for name, value in settings_of(study).items() if name not in ("agents", "names")}
    found = Results(
        lockprobe=version("lockprobe"),
        study=settings | {"agents": list(study.labels)},  # what pages call them: specs may say more than is shown
        settings_hash=study.settings_hash,
        results_hash=numbers.results_hash,
        progress=numbers.progress,
        design=_design(numbers),
    ).with_rows(rows)
    return found.changed(answer=section("The answer", partial(answer_of, found), str))


def _design(numbers: OpenedStudy) -> Design:
    study, design, flips = numbers.study, numbers.design, list[DoseAxis]()
    for modality in study.modalities:
        rates = {one.label: one.p for one in study.flip_axis if one.modality == modality and one.p is not None}
        if len(rates) > 1:
            doses = dict(sorted(rates.items(), key=lambda pair: pair[1]))
            flips.append(DoseAxis(axis=replace(FLIPS, modality=modality, doses=doses)))
    players = players_of(numbers.courses)
    known = {one.agent for one in players}
    others = dict.fromkeys((cell.agent, cell.modality) for cell in numbers.cells if cell.agent not in known)
    players += [Player(agent=agent, modality=shown, subject=agent in numbers.subjects) for agent, shown in others]
    conditions = []
    for one in study.conditions:
        of: dict[str, Any] = {"name": one.label, "specs": one.specs, "modality": one.modality, "doses": dict(one.doses)}
        p, control = one.p if one.label in design.axis else None, design.control(one.label)
        conditions.append(Condition(**of, p=p, control=control if control != one.label else ""))
    return Design(
        conditions=tuple(conditions),
        players=tuple(players),
        axes=(*flips, *(axis for axis, _ in numbers.axes)),
        contrasts=dict(study.contrasts),
        flip_kind=study.flip_kind,
    )


def results(directory: Path | str) -> Results:
    """What a study found, from its records, as a table of rows; equal records give equal results.

    Args:
        directory: The directory of a study.

    Raises:
        BadFile: If it is none.
    """
    with threadpool_limits(ONE_THREAD), leaving_out() as left_out:
        found = results_of(open_study(Path(directory)))
    return found.changed(sections_left_out=tuple(left_out))
