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
from lockprobe.report.judging_nobody import marked, without_verdicts
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.people import people_steps_table, people_table, positions_table
from lockprobe.report.rendering import image, rendered
from lockprobe.report.results import StudyNumbers, results_of, study_numbers, with_left_out
from lockprobe.report.sample_pictures import embedded
from lockprobe.report.schema import Results
from lockprobe.report.why import arm_table, estimate_table
from lockprobe.sections import LeftOutSection, collecting, leaving_out, section

__all__ = ["File", "report_files"]

File = tuple[str, str | bytes | None]
"""A file by its path in the directory, with its content; None for one that is removed."""

_WITHOUT_FIGURES = ("claims", "audit")
"""The pages that show no figure."""


def report_files(
    opened: OpenedStudy,
    *,
    tell: Callable[[str], None],
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
    each: Each,
) -> Iterator[File]:
    """Every file of a report, the report last.

    Args:
        opened: The study.
        tell: Told what it is at.
        left_out: Told every section that could not be made.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    if not opened.finished:
        tell("no trial has ended yet")
    tell(f"testing {len(opened.trials)} trial{'s' * (len(opened.trials) != 1)}")
    with leaving_out() as failed:
        numbers = study_numbers(opened, each=each)
        tell("drawing the figures")
        draw = section("Figures", lambda: study_drawings(numbers, opened.study.box), dict[str, _Draw])
        jobs = [partial(_without_figures, opened, numbers), *(partial(_drawn, name, one) for name, one in draw.items())]
        (content, texts, trials), *done = collecting(each)(operator.call, jobs)
        found = {name: forms for name, forms in zip(draw, done, strict=True) if forms is not None}
        drawn = {name: found[name] for name in (*CAPTIONS, *draw) if name in found}
        photographs = section("What agents saw", lambda: embedded(opened.directory, content.seen), dict[str, str])
        files = [*texts, *_with_figures(content, drawn, photographs, trials)]
        if failed:  # pages and results name what is not in them
            content = with_left_out(content, failed)
            files = [*_texts(content), *_with_figures(content, drawn, photographs, trials)]
    for one in failed:
        left_out(one)
    yield from files


_Draw = Callable[[], dict[str, bytes]]


def _drawn(name: str, draw: _Draw) -> dict[str, bytes] | None:
    """A figure in all its forms; None if it cannot be drawn."""
    return section(f"Figure {name}", draw, lambda: None)


def _without_figures(opened: OpenedStudy, numbers: StudyNumbers) -> tuple[Results, list[File], str]:
    """The results, the files that need no figure, and the explorer's data."""
    content, box = results_of(opened, numbers), opened.settings.get("box", {})
    trials = section("Trial explorer", lambda: explorer_data(opened.trials, box), lambda: explorer_data((), box))
    return content, _texts(content), trials


def _texts(content: Results) -> list[File]:
    """The files that need no figure."""
    files: list[File] = [
        ("results.json", json.dumps(content.plain(), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    ]
    for name, plain in _tables(content).items():
        table = marked(plain, content)
        files += [(f"tables/{name}.csv", as_csv(table)), (f"tables/{name}.tex", as_tex(table))]
    return [*files, *((f"{name}.html", _page(name, content, {})) for name in _WITHOUT_FIGURES)]


def _with_figures(content: Results, drawn: Pictures, photographs: Mapping[str, str], trials: str) -> Iterator[File]:
    """The figures and the pages that show them, the report last; the headings of the courses are verdicts."""
    if content.not_judged:
        drawn = {name: forms for name, forms in drawn.items() if name != "courses"}
    for name, forms in drawn.items():
        for form, picture in forms.items():
            yield f"figures/{name}.{form}", picture
    for name in CAPTIONS.keys() - drawn.keys():
        for form in ("png", "svg"):
            yield f"figures/{name}.{form}", None
    why = ["why"] if content.why else []
    for name in (*why, *(["forks"] if content.forks else []), "report"):
        yield f"{name}.html", _page(name, content, drawn, photographs, trials)


_Table = Callable[[], TextTable]


def _tables(content: Results) -> dict[str, TextTable]:
    """The tables by name; one that cannot be made says so."""
    lazy = _flip_tables(content) | (_condition_tables(content) if content.has_conditions else {})
    return {
        name: without_verdicts(section(f"Table {name}", make, lambda: [["This table could not be made."]]), content)
        for name, make in lazy.items()
    }


def _flip_tables(content: Results) -> dict[str, _Table]:
    subjects = [row for row in content.conditions if row.agent in content.subjects]
    return {
        "table1": lambda: tables.table1(subjects),
        "table1-corrected": lambda: tables.table1_corrected(subjects),
        **({"modalities": lambda: tables.modality_table(content.modalities)} if content.modalities else {}),
        **_people_tables(content),
        "leaderboard": lambda: leaderboard_tables.leaderboard_table(content.leaderboard),
        "leaderboard-by-p": lambda: leaderboard_tables.leaderboard_by_p_table(content.leaderboard),
        "comparisons": lambda: leaderboard_tables.comparison_table(content.comparisons),
        "comparisons-by-p": lambda: leaderboard_tables.comparison_by_p_table(content.comparisons),
        "interactions": lambda: leaderboard_tables.interaction_table(content.interactions),
        "courses": lambda: tables.course_table(content.courses),
        "speed": lambda: tables.speed_table(content.conditions),
        "paces": lambda: tables.pace_table(content.paces),
        "loops": lambda: tables.loop_table(content.conditions),
        **({"lies": lambda: excursion_table(content.lies)} if content.lies else {}),
        **({"forks": lambda: fork_table(content.forks)} if content.forks else {}),
        "rationality": lambda: tables.rationality_table(content.rationality),
        "detectors": lambda: tables.detector_table(content.detectors),
        "conditions": lambda: tables.condition_table(content.conditions),
        "claims": lambda: tables.claim_table(content.claims),
        **_of_measures(content),
    }


def _of_measures(content: Results) -> dict[str, _Table]:
    return {"measures": lambda: measure_table(content.measures)} if content.measures else {}


def _people_tables(content: Results) -> dict[str, _Table]:
    people = content.people
    if people is None or people.found is None:
        return {}
    found, times = people.found, people.response_times
    names = {(row.agent, row.modality): row.label for row in content.conditions}
    return {
        "people": lambda: people_table(found, times),
        "people-steps": lambda: people_steps_table(found, names),
        "people-positions": lambda: positions_table(found),
    }


def _condition_tables(content: Results) -> dict[str, _Table]:
    grids, whys = content.grids, content.why
    return {
        "effects": lambda: tables.effect_table(content.effects),
        "crossings": lambda: tables.crossing_table(content.crossings),
        **({"grids": lambda: grid_table(grids), "trends": lambda: trend_table(grids)} if grids else {}),
        **({"arms": lambda: arm_table(whys), "why": lambda: estimate_table(whys)} if whys else {}),
        "conditions": lambda: tables.table_of_conditions(content.conditions),
    }


def _page(
    name: str, content: Results, drawn: Pictures, photographs: Mapping[str, str] | None = None, trials: str = ""
) -> str:
    """A page; if even its frame cannot be made, one that says so."""
    return section(
        f"Page {name}.html",
        lambda: _rendered(name, content, drawn, photographs or {}, trials),
        lambda: rendered("left_out", content=content, page=name),
    )


def _rendered(name: str, content: Results, drawn: Pictures, photographs: Mapping[str, str], trials: str) -> str:
    several_p = len({row.p for row in content.conditions} - {None}) > 1
    tested = {(t.label, t.question) for t in content.tests if t.recommended and t.p_value is not None}
    return rendered(
        name,
        content=content,
        several_p=several_p,
        not_asked=any(row.not_asked for row in content.leaderboard),
        explorer=_explorer(trials),
        photographs=photographs,
        images={figure: image(forms["svg"]) for figure, forms in drawn.items()},
        captions=_by_variable(captions_of(drawn) | CONDITION_CAPTIONS, content.not_judged),
        series_captions=lambda dose: _by_variable(series_captions(dose), content.not_judged),
        caveat=LENGTH_CAVEAT,
        loop_definition=LOOP_DEFINITION,
        not_valid={rate.test for rate in content.audit.rates if rate.valid is False and not rate.recommended},
        fits=[fit for fit in content.fits if fit.agent in content.subjects and not content.not_judged],
        tests=[
            test
            for test in content.tests
            if test.agent in content.subjects and (several_p or (test.label, test.question) in tested)
        ],
        claims=[list(rows) for _, rows in groupby(content.claims, key=lambda row: row.quote)],
        audit=section("Error rates of the tests", lambda: _audit(content.audit.rates), list[dict[str, Any]]),
        tables={table.replace("-", "_"): rows for table, rows in _tables(content).items()},
    )


def _by_variable(captions: Mapping[str, Caption], not_judged: str) -> dict[str, Caption]:
    """The captions by names that a template can write, each with why no agent is judged by the figure, if none is."""
    return {
        figure.replace("-", "_"): text._replace(shown=f"{text.shown} {not_judged}".rstrip())
        for figure, text in captions.items()
    }


def _explorer(trials: str) -> dict[str, Any]:
    """What a page needs to step through trials: their data, the program and its hash; all of it is our own text."""
    from markupsafe import Markup

    return {"trials": Markup(trials), "script": Markup(script()), "hash": script_hash()}  # noqa: S704  JSON without <


def _audit(rates: Sequence[AuditedRate]) -> list[dict[str, Any]]:
    """The audit's rates by question and test, one for every world."""
    by_test: dict[str, list[AuditedRate]] = {}
    for rate in rates:
        by_test.setdefault(rate.test, []).append(rate)
    return [
        {"asks": asks, "tests": [found for found in by_test.values() if found[0].question == question]}
        for question, asks in QUESTIONS.items()
    ]
