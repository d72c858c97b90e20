"""``suite.html`` and ``suite.json``: the scores of a suite on one self-contained page without scripts."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import NONE, bracketed, percent, share
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.foundation.storage.atomic_file import write_files
from lockprobe.report.format import TextTable, share_cell
from lockprobe.report.prose.suite import ranks_said, suite_said
from lockprobe.report.rendering import rendered
from lockprobe.report.section import Caption
from lockprobe.report.suite.results import SuiteResults
from lockprobe.report.svg import image
from lockprobe.statistics.suite.scores import Rational, Score, SuiteScore
from lockprobe.studies.file_names import SCORES

__all__ = ["PAGE", "level_table", "score_table", "suite_page", "write_suite"]

PAGE = "suite.html"

_CAPTION = Caption(
    "Five scores of each agent, the most competent at the top. Short upright lines in the last panel: rationality of "
    "random choices in the same situations.",
    "Bars are 95 % intervals.",
)


def write_suite(
    found: SuiteResults, directory: Path, *, left_out: Callable[[LeftOutSection], None] = lambda section: None
) -> Path:
    """Write scores and page together. A table or figure that cannot be made is left out and named.

    Args:
        found: The scores.
        directory: The directory of the suite.
        left_out: Told every score, table and figure that could not be made.

    Returns:
        Where the page is.

    Raises:
        BadFile: If they cannot be written.
    """
    found, page = suite_page(found)
    for one in found.sections_left_out:
        left_out(one)
    scores = json.dumps(found.plain(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        write_files({directory / SCORES: scores, directory / PAGE: page})
    except OSError as error:
        raise BadFile(directory, f"cannot be written ({error.strerror})") from error
    return directory / PAGE


def suite_page(found: SuiteResults) -> tuple[SuiteResults, str]:
    """The page of a suite, and the scores with every table and figure that could not be made."""
    with leaving_out() as failed:
        page = _page(found)
        if failed:
            found = replace(found, sections_left_out=(*found.sections_left_out, *failed))
            page = _page(found)
    return found, page


def _page(found: SuiteResults) -> str:
    shown = [(one.name, one.scores) for one in found.entries]
    picture = section("Figure scores", lambda: _picture(shown) if shown else {}, dict[str, bytes])
    return rendered(
        "suite",
        content=found,
        said=section(
            "First sentence",
            lambda: suite_said(shown, stops=found.suite.until is not None),
            lambda: "The answer could not be computed.",
        ),
        lockprobe=found.plain()["lockprobe"],
        images={"scores": image(picture["svg"])} if picture else {},
        caption=_CAPTION,
        tables={
            name: section(f"Table {name}", partial(make, found), lambda: [["This table could not be made."]])
            for name, make in (("scores", score_table), ("levels", level_table), ("boxes", _box_table))
        },
    )


def _picture(entries: Sequence[tuple[str, SuiteScore]]) -> dict[str, bytes]:
    """The figure of the scores of a suite as PNG and SVG."""
    from lockprobe.report import figures
    from lockprobe.report.figures.suite import suite_drawing

    return figures.files(suite_drawing(entries))


def score_table(found: SuiteResults) -> TextTable:
    """The five scores of every agent."""
    rows = [["agent", "competence", "rank", "robustness", "misreading", "loops", "rationality", "trials"]]
    for one in found.entries:
        scores = one.scores
        optimal = _cell(scores.rationality, share)
        if scores.rationality:
            optimal += f", chance {percent(scores.rationality.chance)}"
        most = f"at most {one.planned}" if found.suite.until else one.planned
        trials = f"{scores.trials} of {most}" if one.partial or scores.broken else str(scores.trials)
        rows.append(
            [
                one.name,
                _cell(scores.competence, share),
                (ranks_said(scores) or NONE) if found.suite.until is None else NONE,
                _cell(scores.robustness, bracketed),
                _cell(scores.misreading, share),
                _cell(scores.loops, bracketed),
                optimal,
                trials,
            ]
        )
    return rows


def _cell(found: Score | Rational | None, form: Callable[[float, float, float], str]) -> str:
    return NONE if found is None else form(found.value, found.low, found.high)


def level_table(found: SuiteResults) -> TextTable:
    """Success of every agent at every level, with true and with false reports."""
    rows = [["agent", "reports", *(level["box"] for level in found.levels)]]
    for one in found.entries:
        levels = one.scores.levels
        rows.append([one.name, "true", *(share_cell(level.told) for level in levels)])
        rows.append([one.name, "false at 0.4", *(share_cell(level.misled) for level in levels)])
    return rows


def _box_table(found: SuiteResults) -> TextTable:
    head = ["box", "joints", "fewest steps", "solved by chance"]
    numbers = [(one["box"], str(one["joints"]), str(one["optimum"]), percent(one["chance"], 1)) for one in found.levels]
    return [head, *map(list, numbers)]
