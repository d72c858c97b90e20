"""Everything that a report writes: numbers, figures, tables, and three self-contained pages.

The pages are made from what ``results.json`` holds, from the figures and from the pictures that agents saw, of nothing
else: equal records give equal pages. What comes from agents, models and box files is untrusted: it is escaped, without
characters that hide or reorder others. ``report.html`` runs one script, our own (:mod:`lockprobe.report.explorer`);
the other pages run none.
"""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby
from typing import Any

from lockprobe.analysis.inference.association import LENGTH_CAVEAT
from lockprobe.parallel import Each
from lockprobe.prose.hypothesis_tests import QUESTIONS
from lockprobe.prose.loops import LOOP_DEFINITION
from lockprobe.report import leaderboard_tables, tables
from lockprobe.report.details import AuditedRate
from lockprobe.report.dose_grids import grid_table, trend_table
from lockprobe.report.excursions import excursion_table
from lockprobe.report.explorer import explorer_data, script, script_hash
from lockprobe.report.figures import (
    CAPTIONS,
    CONDITION_CAPTIONS,
    Caption,
    Pictures,
    captions_of,
    series_captions,
    study_drawings,
)
from lockprobe.report.forks import fork_table
from lockprobe.report.format import TextTable, as_csv, as_tex
from lockprobe.report.installed_measures import measure_table
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.people import people_steps_table, people_table, positions_table
from lockprobe.report.rendering import image, rendered
from lockprobe.report.results import StudyNumbers, results_of, study_numbers
from lockprobe.report.sample_pictures import embedded
from lockprobe.report.schema import Results
from lockprobe.report.why import arm_table, estimate_table

__all__ = ["File", "report_files"]

File = tuple[str, str | bytes | None]
"""A file by its path in the directory, with its content; None for one that is removed."""

_WITHOUT_FIGURES = ("claims", "audit")
"""The pages of a study of flip rates that show no figure."""


def report_files(opened: OpenedStudy, *, tell: Callable[[str], None], each: Each) -> Iterator[File]:
    """Every file of a report, the report last.

    Args:
        opened: The study.
        tell: Told what it is at.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    if not opened.finished:
        tell("no trial has ended yet")
    tell(f"testing {len(opened.trials)} trial{'s' * (len(opened.trials) != 1)}")
    numbers = study_numbers(opened, each=each)
    tell("drawing the figures")
    draw = study_drawings(numbers, opened.study.box)
    (content, files, trials), *done = each(operator.call, [partial(_without_figures, opened, numbers), *draw.values()])
    found = dict(zip(draw, done, strict=True))
    drawn = {name: found[name] for name in (CAPTIONS if content.of_flips else draw) if name in found}
    yield from files
    yield from _with_figures(content, drawn, embedded(opened.directory, content.seen), trials)


def _without_figures(opened: OpenedStudy, numbers: StudyNumbers) -> tuple[Results, list[File], str]:
    """The results, the files that need no figure, and the explorer's data."""
    content = results_of(opened, numbers)
    files: list[File] = [
        ("results.json", json.dumps(content.plain(), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    ]
    for name, table in _tables(content).items():
        files += [(f"tables/{name}.csv", as_csv(table)), (f"tables/{name}.tex", as_tex(table))]
    pages = _WITHOUT_FIGURES if content.of_flips else ()
    files += [(f"{name}.html", _page(name, content, {})) for name in pages]
    return content, files, explorer_data(opened.trials, opened.settings.get("box", {}))


def _with_figures(content: Results, drawn: Pictures, photographs: Mapping[str, str], trials: str) -> Iterator[File]:
    """The figures and the pages that show them, the report last."""
    for name, forms in drawn.items():
        for form, picture in forms.items():
            yield f"figures/{name}.{form}", picture
    for name in CAPTIONS.keys() - drawn.keys():
        for form in ("png", "svg"):
            yield f"figures/{name}.{form}", None
    why = ["why"] if content.why and not content.of_flips else []
    for name in (*why, *(["forks"] if content.forks else []), "report"):
        yield f"{name}.html", _page(name, content, drawn, photographs, trials)


def _tables(content: Results) -> dict[str, TextTable]:
    """The tables by name."""
    if not content.of_flips:
        return _condition_tables(content)
    subjects = [row for row in content.conditions if row.agent in content.subjects]
    return {
        "table1": tables.table1(subjects),
        "table1-corrected": tables.table1_corrected(subjects),
        **({"modalities": tables.modality_table(content.modalities)} if content.modalities else {}),
        **_people_tables(content),
        "leaderboard": leaderboard_tables.leaderboard_table(content.leaderboard),
        "leaderboard-by-p": leaderboard_tables.leaderboard_by_p_table(content.leaderboard),
        "comparisons": leaderboard_tables.comparison_table(content.comparisons),
        "comparisons-by-p": leaderboard_tables.comparison_by_p_table(content.comparisons),
        "interactions": leaderboard_tables.interaction_table(content.interactions),
        "courses": tables.course_table(content.courses),
        "speed": tables.speed_table(content.conditions),
        "paces": tables.pace_table(content.paces),
        "loops": tables.loop_table(content.conditions),
        **({"lies": excursion_table(content.lies)} if content.lies else {}),
        **({"forks": fork_table(content.forks)} if content.forks else {}),
        "rationality": tables.rationality_table(content.rationality),
        "detectors": tables.detector_table(content.detectors),
        "conditions": tables.condition_table(content.conditions),
        "claims": tables.claim_table(content.claims),
        **_of_measures(content),
    }


def _of_measures(content: Results) -> dict[str, TextTable]:
    return {"measures": measure_table(content.measures)} if content.measures else {}


def _people_tables(content: Results) -> dict[str, TextTable]:
    people = content.people
    if people is None or people.found is None:
        return {}
    names = {(row.agent, row.modality): row.label for row in content.conditions}
    return {
        "people": people_table(people.found, people.response_times),
        "people-steps": people_steps_table(people.found, names),
        "people-positions": positions_table(people.found),
    }


def _condition_page(name: str, content: Results, drawn: Pictures, photographs: Mapping[str, str], trials: str) -> str:
    return rendered(
        name,
        content=content,
        explorer=_explorer(trials),
        photographs=photographs,
        images={figure: image(forms["svg"]) for figure, forms in drawn.items()},
        captions=_by_variable(CONDITION_CAPTIONS),
        series_captions=series_captions,
        tables=_condition_tables(content),
    )


def _condition_tables(content: Results) -> dict[str, TextTable]:
    return {
        "effects": tables.effect_table(content.effects),
        "crossings": tables.crossing_table(content.crossings),
        **({"grids": grid_table(rows), "trends": trend_table(rows)} if (rows := content.grids) else {}),
        **({"arms": arm_table(content.why), "why": estimate_table(content.why)} if content.why else {}),
        **({"forks": fork_table(content.forks)} if content.forks else {}),
        "conditions": tables.table_of_conditions(content.conditions),
        **_of_measures(content),
    }


def _page(
    name: str, content: Results, drawn: Pictures, photographs: Mapping[str, str] | None = None, trials: str = ""
) -> str:
    if not content.of_flips:
        return _condition_page("conditions" if name == "report" else name, content, drawn, photographs or {}, trials)
    several_p = len({row.p for row in content.conditions}) > 1
    tested = {(t.label, t.question) for t in content.tests if t.recommended and t.p_value is not None}
    return rendered(
        name,
        content=content,
        several_p=several_p,
        not_asked=any(row.not_asked for row in content.leaderboard),
        explorer=_explorer(trials),
        photographs=photographs or {},
        images={figure: image(forms["svg"]) for figure, forms in drawn.items()},
        captions=_by_variable(captions_of(drawn)),
        caveat=LENGTH_CAVEAT,
        loop_definition=LOOP_DEFINITION,
        not_valid={rate.test for rate in content.audit.rates if rate.valid is False and not rate.recommended},
        fits=[fit for fit in content.fits if fit.agent in content.subjects],
        tests=[
            test
            for test in content.tests
            if test.agent in content.subjects and (several_p or (test.label, test.question) in tested)
        ],
        claims=[list(rows) for _, rows in groupby(content.claims, key=lambda row: row.quote)],
        audit=_audit(content.audit.rates),
        tables={table.replace("-", "_"): rows for table, rows in _tables(content).items()},
    )


def _by_variable(captions: Mapping[str, Caption]) -> dict[str, Caption]:
    """The captions by names that a template can write."""
    return {figure.replace("-", "_"): text for figure, text in captions.items()}


def _explorer(trials: str) -> dict[str, Any]:
    """What a page needs to step through trials: their data, the program and its hash; all of it is our own text."""
    from markupsafe import Markup

    return {"trials": Markup(trials), "script": Markup(script()), "hash": script_hash()}  # noqa: S704  JSON without <


def _audit(rates: Sequence[AuditedRate]) -> list[dict[str, Any]]:
    """The audit's rates by question and test, one for every world."""
    by_test = {name: [rate for rate in rates if rate.test == name] for name in [rate.test for rate in rates]}
    return [
        {"asks": asks, "tests": [found for found in by_test.values() if found[0].question == question]}
        for question, asks in QUESTIONS.items()
    ]
