"""``lockprobe verify``: recomputes a study from its records and says what does not hold."""

from __future__ import annotations

import json as json_
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli.printing import time_left
from lockprobe.report.verification import verify as verify_study
from lockprobe.terminal_text import printable

__all__ = ["verify"]

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]

_NAMED = 5
"""What fails, by name; --json has the rest."""


def verify(directory: Directory, json: AsJson = False) -> None:
    """Recompute a study from its records: checksums, settings, luck, choices of strategies, and results.json.

    Ends with 1 if anything does not hold. What models and people answered is taken from the records.
    """
    checks = verify_study(directory, tell=time_left("trials"))
    holds = all(check.holds for check in checks)
    if json:
        print(json_.dumps({"holds": holds, "checks": [asdict(check) for check in checks]}))
    else:
        for check in checks:
            print(f"{'holds' if check.holds else 'FAILS'}  {check.name:9} {printable(check.said)}")
            for name in check.failed[:_NAMED]:
                print(f"                 {printable(name)}")
            if len(check.failed) > _NAMED:
                print(f"                 and {len(check.failed) - _NAMED} more (--json)")
    raise typer.Exit(0 if holds else 1)
