"""``lockprobe verify``: recomputes a study from its records and reports every check that fails."""

from __future__ import annotations

import json as json_
from dataclasses import asdict
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import time_left
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies import SETTINGS
from lockprobe.studies.records.store import STORE

_SETTINGS = "The hash of the settings, as it was published."
_RESULTS = "The hash of the results, as it was published."

_NAMED = 5
"""The most failures printed by name; --json has all."""


def verify(
    directory: options.Directory,
    settings: Annotated[str | None, typer.Option(metavar="HASH", help=_SETTINGS)] = None,
    results: Annotated[str | None, typer.Option(metavar="HASH", help=_RESULTS)] = None,
    json: options.AsJson = False,
) -> None:
    """Recompute a study from its records, and hold replies, logs and report against them.

    Published hashes of settings and results are compared with --settings and --results. Exit status 1: a check failed.
    """
    if not any((directory / name).exists() for name in (SETTINGS, STORE)):
        raise BadFile(directory, f"no {SETTINGS} here; is it the directory of a study?")
    # two seconds of imports, which --help need not wait for
    from lockprobe.report.verify import NOT_SHOWN
    from lockprobe.report.verify import verify as verify_study

    checks = verify_study(directory, settings=settings, results=results, tell=time_left("trials"))
    holds = all(one.holds for one in checks)
    if json:
        found = [asdict(one) | {"holds": one.holds} for one in checks]
        print(json_.dumps({"holds": holds, "checks": found, "not_shown": NOT_SHOWN}))
    else:
        wide = max(len(one.name) for one in checks)
        for one in checks:
            exceptions = "" if one.holds else f"{count(len(one.failed), 'exception')} to: "
            said, *failed = [f"{exceptions}{one.said}"] * bool(one.said) + [*one.failed]
            print(f"{'holds' if one.holds else 'FAILS'}  {one.name:{wide}}  {printable(said)}")
            more = [f"and {len(failed) - _NAMED} more (--json)"] * (len(failed) > _NAMED)
            for line in (*failed[:_NAMED], *more):
                print(f"{'':{wide + 9}}{printable(line)}")
        print(f"{NOT_SHOWN}.")
    raise typer.Exit(0 if holds else 1)
