"""Options that are not those of a study, and words for them, so that commands spell and explain them in one way.

What a command says of an option in brackets, the default or what it means there, may differ. The options that describe
a study are those of :class:`lockprobe.studies.options.study_options.StudyOptions`; see ``lockprobe.cli.study_options``.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import spec_kind

ACTIONS = "Number of different actions."
BOX = "A box by name, random-N-SEED, or a TOML file."
HOST = "Host name or IP address."
LAYOUT = "Where joints lie on the panel."
OUT = "Where the result is written."
PLANT = "What is acted on: a plant that lockprobe list plants lists, with options as in twin?looks=varied."
SEED = "Seed of everything."
STUDIES = "Simulated studies of each kind."

_ALLOW = "Code of yours that the directory names, as python:MODULE:NAME; it runs only if named; may be repeated (none)."
_BUDGET = "The most that the study may cost in US dollars, earlier runs included; it is never exceeded."
_CLUSTER = "A Ray cluster on whose processors agents and plants that ship are played; see docs/cluster.md (none)."
_ESTIMATE = "Only estimate the cost; call no model and write nothing."
_RETRIES = "How often a request without an answer is made again."


def with_brackets(text: str, here: str) -> str:
    """The text of an option with what holds in one command.

    >>> with_brackets("Number of joints.", "4")
    'Number of joints (4).'
    """
    return f"{text.removesuffix('.')} ({here})."


def _directory(path: str) -> Path:
    """Nothing is the current directory only for those who write a dot."""
    if not path:
        raise BadValue("out", path, "a directory")
    return Path(path)


Allow = Annotated[list[str] | None, typer.Option("--allow", metavar="SPEC", help=_ALLOW)]
AsJson = Annotated[bool, typer.Option("--json", help="JSON: one object, or one a line.")]
Box = Annotated[str, typer.Option(help=BOX)]
Budget = Annotated[float | None, typer.Option(metavar="DOLLARS", help=_BUDGET)]
ClusterAt = Annotated[str | None, typer.Option("--cluster", metavar="auto|HOST:PORT", help=_CLUSTER)]
Connections = Annotated[int, typer.Option(min=1, help="Requests to providers in progress at once.")]
EstimateOnly = Annotated[bool, typer.Option("--estimate", help=_ESTIMATE)]
Out = Annotated[
    Path | None, typer.Option(metavar="DIR", parser=_directory, help=with_brackets(OUT, "lockprobe-runs/STUDY-HASH"))
]
Port = Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 for any free one.")]
Retries = Annotated[int, typer.Option(help=_RETRIES)]
Seed = Annotated[int, typer.Option(min=0, help=SEED)]
Timeout = Annotated[float, typer.Option(help="Seconds after which a hanging request is made again.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes (one per core, at most 8).")]


def permit(specs: Iterable[str] | None) -> None:
    """Let code of ``--allow`` run.

    Raises:
        BadValue: If it names none.
    """
    for spec in specs or ():
        if spec_kind(spec) != "python":
            raise BadValue("allow", spec, "python:MODULE:NAME")
        allow(spec)
