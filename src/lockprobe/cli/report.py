"""``lockprobe report``: writes the report of a study, compares several on one page, or reports a file of episodes."""

from __future__ import annotations

import json as json_
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import print_rows
from lockprobe.cli.result import read_result, write
from lockprobe.cli.study_options import study_help
from lockprobe.foundation.errors import Conflict
from lockprobe.foundation.terminal_text import printable

_PAPER = "Also write paper/: the exhibits of the paper and all other figures as PDF, tables and methods in TeX."

_PAGE = Path("compare.html")

_DIRECTORIES = "The directory of a study; several are compared on one page. Or files of anyone's episodes."
_AGENT = study_help("agent", "all; of several studies, fewer need less correction")
_OUT = options.with_brackets(options.OUT, f"several studies: {_PAGE}; episodes: NAME-report")
_MAP = "Of episodes: which column is which, a TOML file or one of inspect, balrog, gymnasium (their own names)."
_FIRST = "Of episodes: loops are compared in so many first steps."


def report(
    directories: Annotated[list[Path], typer.Argument(metavar="DIR|FILE...", help=_DIRECTORIES)],
    paper: Annotated[bool, typer.Option("--paper", help=_PAPER)] = False,
    agent: Annotated[list[str] | None, typer.Option(help=_AGENT)] = None,
    out: Annotated[Path | None, typer.Option(metavar="PATH", help=_OUT)] = None,
    columns: Annotated[str, typer.Option("--map", metavar="FILE|NAME", help=_MAP)] = "",
    first: Annotated[int, typer.Option(min=6, max=1000, help=_FIRST)] = 20,
    json: options.AsJson = False,
) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records; compare several studies on one page.

    Of several studies the page has every agent's success under the conditions that they share, and differences.
    Conditions are matched by what acts in them, whatever they are called; what only one study has is named. Studies of
    one seed share their luck and are compared trial by trial; others are independent samples. Studies of different
    boxes, budgets of steps, plants or modalities are refused.

    A file of episodes (.csv, .jsonl, .parquet, or a log of Inspect) has a row an episode or a step of any task.
    """
    if columns or any(one.suffix and not one.is_dir() for one in directories):
        if paper or agent:
            raise Conflict("--paper and --agent", "a file of episodes", "they are of studies")
        from lockprobe.interfaces.episodes.page import write_episodes

        out = out or Path(f"{directories[0].stem}-report")
        found = write_episodes(directories, columns, first=first, out=out)
        notes = [fact.text for fact in found.facts]
        facts: dict[str, object] = {"report": str(out / "report.html"), "answer": found.answer, "notes": notes}
        lines = [f"Report: {facts['report']}", f"Answer: {found.answer}", *notes]
    elif len(directories) > 1:
        if paper:
            raise Conflict("--paper", "several studies", "it is of the report of one")
        _compare(directories, agent or (), out or _PAGE, json=json)
        return
    elif agent or out:
        raise Conflict("--agent and --out", "one study", "its report has every agent and stands in its directory")
    else:
        page, (lines, facts) = write(directories[0])
        facts = {"report": str(page), **facts}
        if paper and (study := read_result(directories[0])) is not None:
            from lockprobe.report.paper import write_paper  # it imports the report, for which help need not wait

            facts["paper"] = where = str(write_paper(study, directories[0]))
            lines.insert(1, f"Paper: {where} (the exhibits by their names in the paper; example.tex puts all together)")
    print(json_.dumps(facts) if json else "\n".join(map(printable, lines)), flush=True)


def _compare(directories: Sequence[Path], agents: Sequence[str], out: Path, *, json: bool) -> None:
    from lockprobe.cli.export import refuse_study_file
    from lockprobe.report.compare import TABLES, compare_studies, write_comparison
    from lockprobe.report.format import texts

    refuse_study_file(out)
    found = compare_studies(directories, agents)
    path = write_comparison(found, out / _PAGE if out.is_dir() else out)
    if json:
        print(json_.dumps(found.plain() | {"page": str(path)}, allow_nan=False))
        return
    partial = [one for one in found.studies if one["partial"]]
    apart = [one for one in found.studies if one["not_shared"]]
    for line in (
        found.said,
        *(f"Partial: {one['finished']} of {one['planned']} trials of {one['name']} are finished." for one in partial),
        *(f"Only in {one['name']}: {'; '.join(one['not_shared'])}." for one in apart),
        *(f"Different settings: {line}" for line in found.unlike),
    ):
        print(printable(line))
    for name in ("success", "differences"):
        print()
        print_rows(texts([*TABLES[name](found)]))
    print(f"Comparison: {path}")
