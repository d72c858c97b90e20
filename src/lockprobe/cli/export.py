"""``lockprobe export``: exports the trials of a study for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.formatting import count
from lockprobe.foundation.plugins import robot_plugin
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.interfaces.export import TableName, table_of
from lockprobe.studies import FORKS, PAGE, PEOPLE_DIRECTORY, RESULTS, SETTINGS
from lockprobe.studies.records.read_records import stored_records
from lockprobe.studies.records.store import ALBUM, STORE, read

Format = Literal["csv", "jsonl", "parquet", "frames"]

_TABLE = "A row per step, trial, call of a model, participant, act or answer. Records: a line per trial."
_IDS = "Include people's IDs of the platform; they are personal data."
_TRIAL = "Frames of this trial alone, by its key or its beginning or end."
_OUT = options.with_brackets(options.OUT, "standard output, also with -")

_OF_STUDY = {SETTINGS, RESULTS, PAGE, ALBUM, PEOPLE_DIRECTORY, FORKS}
"""What no command replaces, beside the store and what is named after it; beside figures and tables there is room."""


def export(
    directory: options.Directory,
    format: Annotated[Format, typer.Option(help="The kind of file.")] = "csv",  # noqa: A002
    table: Annotated[Literal[TableName, "records"], typer.Option(help=_TABLE)] = "steps",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
    platform_ids: Annotated[bool, typer.Option("--with-platform-ids", help=_IDS)] = False,
    trial: Annotated[str, typer.Option(metavar="KEY", help=_TRIAL)] = "",
) -> None:
    """Export a study: a table of its steps, trials or calls, or frames: pictures and depth with the camera.

    A table FILE comes with its data dictionary, FILE-metadata.json, which describes every column. Records are what the
    hash of the results covers: everything of a trial in one JSON object, in the order of their keys.
    """
    out = None if str(out) == "-" else out
    if trial and format != "frames":
        raise BadValue("--trial", trial, "--format frames with it")
    if format == "frames":
        if out is None:
            raise BadValue("--out", None, "a directory for the pictures")
        write_frames = robot_plugin("tool", "frames", "frames need").load()
        written = write_frames(directory, out, only=trial, tell=lambda said: print(f"Frames: {said}", file=sys.stderr))
        print(f"{out} ({count(written, 'frame')})")
        return
    if out is not None:
        refuse_study_file(out)
    if table == "records":
        _export_records(directory, format, out)
    elif out is not None:
        for path in table_of(directory, table, platform_ids=platform_ids).write(out, format):
            print(path)
    elif format == "parquet":
        raise BadValue("--out", None, "a file to write, because parquet is not text")
    else:
        table_of(directory, table, platform_ids=platform_ids).write_text(sys.stdout, format)


def _export_records(directory: Path, format: Format, out: Path | None) -> None:  # noqa: A002
    if format != "jsonl":
        raise BadValue("--format", format, "jsonl, because a record is a JSON object")
    with read(directory) as store:
        records = (record + b"\n" for record in stored_records(store))
        if out is None:
            sys.stdout.buffer.writelines(records)
            return
        with atomic_files(out) as (draft,), draft.open("wb") as file:
            file.writelines(records)
    print(out)


def refuse_study_file(out: Path) -> None:
    """Refuse to replace a file of any study, also through a link.

    Raises:
        BadFile: If ``out`` is such a file.
    """
    file = out.resolve()
    for place in file.parents:
        name = file.relative_to(place).parts[0]
        if (place / SETTINGS).is_file() and (name in _OF_STUDY or name.startswith(STORE)):
            raise BadFile(out, "belongs to the study; choose another file")
