"""``lockprobe report``: writes the report of a study directory."""

from __future__ import annotations

import json as json_
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.cluster import reached
from lockprobe.cli.result import read_result, result_facts, result_lines
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.left_out import LeftOutSection, without
from lockprobe.foundation.parallel import Pool
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.write import write_report

if TYPE_CHECKING:
    from lockprobe.report.rows import Results

__all__ = ["report"]

_PAPER = "Also write paper/: the figure for print, all figures as PDF, a table and a paragraph on the methods in TeX."
_WATCH = "Update the report while the study runs, until all planned trials are finished or Ctrl-C."

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
ForPaper = Annotated[bool, typer.Option("--paper", help=_PAPER)]
Watch = Annotated[bool, typer.Option("--watch", help=_WATCH)]


def report(
    directory: Directory,
    watch: Watch = False,
    paper: ForPaper = False,
    cluster: options.ClusterAt = None,
    json: options.AsJson = False,
) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records.

    With --cluster, the cluster computes and draws a large report.
    """
    if watch and paper:
        raise BadValue("paper", "with --watch", "one of both: a paper is of a finished report")
    with reached(cluster) as machines:
        if not watch:
            _write(directory, machines, paper=paper, json=json)
            return
        from lockprobe.cli.watch_report import (  # what it imports, a report imports twice at once
            owed_trials,
            watch_report,
        )

        try:
            watch_report(directory, lambda: _write(directory, machines, json=json))
        except KeyboardInterrupt:
            print(f"Report: stopped by Ctrl-C; trials still owed: {owed_trials(directory)}", file=sys.stderr)


def _for_paper(found: Results, directory: Path) -> Path:
    from lockprobe.report.paper import write_paper  # it imports the report, for which help need not wait

    return write_paper(found, directory)


def _write(directory: Path, machines: Pool | None, *, paper: bool = False, json: bool) -> None:
    tell = partial(print, "Report:", file=sys.stderr)
    left_out: list[LeftOutSection] = []
    path = write_report(directory, tell=tell, left_out=left_out.append, processes=2, elsewhere=machines)
    found = read_result(directory)
    for_paper = _for_paper(found, directory) if paper and found is not None else None
    if json:
        missing = {"left_out": [one.plain() for one in left_out]} if left_out else {}
        facts = {} if found is None else result_facts(found, directory)
        said = {"report": str(path), **facts, **missing, **({"paper": str(for_paper)} if for_paper else {})}
        print(json_.dumps(said), flush=True)
        return
    print(f"Report: {path}{without(left_out)}")
    if for_paper:
        print(f"Paper: {for_paper}/paper.pdf (the figure in one column and in two), paper.tex (the table), methods.tex")
    for line in result_lines(found, directory) if found is not None else ():
        print(printable(line))
    sys.stdout.flush()
