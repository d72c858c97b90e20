"""``lockprobe compare``: compares studies."""

from __future__ import annotations

import json as json_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.cli.printing import print_rows
from lockprobe.cli.study_options import study_help
from lockprobe.foundation.left_out import LeftOutSection, without
from lockprobe.foundation.terminal_text import printable

if TYPE_CHECKING:
    from lockprobe.report.compare.studies import Comparison

__all__ = ["compare"]

PAGE = Path("compare.html")

_LONGEST = 300
"""The most characters of a line on different settings."""

Directories = Annotated[
    list[Path], typer.Argument(metavar="DIR DIR...", help="The directories of two or more studies.")
]
Agents = Annotated[
    list[str] | None,
    typer.Option("--agent", help=study_help("agent", "all; fewer need less correction")),
]
Out = Annotated[Path, typer.Option(metavar="FILE", help=options.with_brackets(options.OUT, "a page"))]


def compare(directories: Directories, agent: Agents = None, out: Out = PAGE, json: options.AsJson = False) -> None:
    """Compare studies: success of every agent under the conditions that the studies share, and every difference.

    Conditions are matched by what acts in them, whatever they are called; what only one study has is named. Studies of
    one seed share their luck and are compared trial by trial; others are independent samples. Studies of different
    boxes, budgets of steps, plants or modalities are refused.
    """
    from lockprobe.report.compare.page import write_comparison
    from lockprobe.report.compare.studies import (
        compare_studies,  # two seconds of imports, which --help need not wait for
    )

    refuse_study_file(out)
    found = compare_studies(directories, agent or ())
    left_out: list[LeftOutSection] = []
    path = write_comparison(found, out / PAGE if out.is_dir() else out, left_out=left_out.append)
    if json:
        print(json_.dumps(found.plain() | {"page": str(path)}, allow_nan=False))
        return
    _print(found)
    print(f"Comparison: {path}{without(left_out)}")


def _print(found: Comparison) -> None:
    from lockprobe.report.compare.page import difference_table, success_table
    from lockprobe.report.prose.study_comparison import leading

    print(printable(found.said))
    for one in found.studies:
        if one.partial:
            print(printable(f"Partial: {one.finished} of {one.planned} trials of {one.name} are finished."))
    for one in found.studies:
        if one.not_shared:
            print(printable(f"Only in {one.name}: {'; '.join(one.not_shared)}."))
    for line in found.unlike:
        print(printable(f"Different settings: {line[:_LONGEST]}"))
    first = leading(found.differences)
    for rows in (success_table(found), difference_table(found, first)):
        print()
        print_rows(rows)
    if left := len(found.differences) - len(first):
        print(f"{left} more differences, with baselines or within one study, are on the page.")
