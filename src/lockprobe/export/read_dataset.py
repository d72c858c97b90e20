"""Reads a Psych-DS dataset back into trials and checks its tables against its records.

A dataset is untrusted: no file name is taken from its content, no link is followed, and no file larger than any study
of people is read.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.export.data_dictionary import PLATFORM, as_bits, column
from lockprobe.export.tables import PeopleRecords, Table, tables_of
from lockprobe.export.write_dataset import DATA, DESCRIPTION, RECORDS, data_file
from lockprobe.inputs import check_regular
from lockprobe.studies.merge import MergeSource, source_of_directory
from lockprobe.terminal_text import readable

__all__ = ["LARGEST_FILE", "is_dataset", "source_of_dataset"]

LARGEST_FILE = 1 << 28
"""The largest file of a dataset, in bytes."""

_LATER_TABLES = {"trials"}
_LATER_COLUMNS = {"conditions", "finished", "pointers", "window_width", "window_height"}
"""Columns that older datasets lack; if present, they are checked against the records like all others."""


def is_dataset(directory: Path) -> bool:
    """Whether a directory is a dataset of :func:`lockprobe.export.write_dataset.write_dataset`."""
    return (directory / DESCRIPTION).is_file() and (directory / RECORDS).is_dir()


def source_of_dataset(directory: Path) -> MergeSource:
    """The trials in a dataset.

    Raises:
        BadFile: If a file is damaged, a link or too large, or if a table is missing or disagrees with the records.
            Additional columns are ignored.
    """
    for path in _files(directory):
        if path.is_symlink():
            raise BadFile(path, "a link; a dataset must contain its files")
        check_regular(path)
        if path.stat().st_size > LARGEST_FILE:
            raise BadFile(path, f"larger than {LARGEST_FILE >> 20} MiB")
    records = PeopleRecords.read(directory / RECORDS)
    for table in tables_of(records):
        path = directory / DATA / data_file(records.study, table.name)
        if path.exists() or table.name not in _LATER_TABLES:
            _hold_together(path, table)
    return source_of_directory(directory / RECORDS)


def _files(directory: Path) -> Iterator[Path]:
    """All files in a directory and below; links to directories are not followed."""
    for where, directories, files in os.walk(directory):
        links = (name for name in directories if (Path(where) / name).is_symlink())
        yield from (Path(where) / name for name in (*files, *links))


def _hold_together(path: Path, table: Table) -> None:
    """Refuse a file that disagrees with the table made from the records."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file, strict=True)
            there = list(reader)
            columns = list(reader.fieldnames or ())
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise BadFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if repeated := [name for name in table.columns if columns.count(name) > 1]:
        raise BadFile(path, f"has two columns {repeated[0]}")
    of_now = _LATER_COLUMNS if table.name == "participants" else set[str]()
    if missing := [name for name in table.columns if name not in columns and name not in of_now]:
        raise BadFile(path, f"has no column {missing[0]}")
    if len(there) != len(table.rows):
        raise BadFile(path, f"has {len(there)} rows, and the records have {len(table.rows)}")
    for number, (found, row) in enumerate(zip(there, table.rows, strict=True), 1):
        for name in (name for name in table.columns if name in columns):
            if not _same(name, found[name], recorded := str(row.get(name, ""))):
                raise BadFile(path, f"row {number}: {name} is {found[name]!r}, and {recorded!r} in the records")


def _same(name: str, found: str | None, recorded: str) -> bool:
    """Whether a cell agrees with the records; older datasets have configurations without ``b``."""
    if found is None:  # the row is too short
        return False
    bits = not name.startswith(PLATFORM) and column(name).kind == "bits"
    return readable(found) == recorded or (bits and as_bits(found) == recorded)
