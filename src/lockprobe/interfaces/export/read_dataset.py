"""Reads a Psych-DS dataset back into trials and checks its tables against its records.

A dataset is untrusted: no file name is taken from its content, no link is followed, and no file larger than any study
of people is read.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.terminal_text import readable
from lockprobe.interfaces.export.tables import PeopleRecords, Table, tables_of
from lockprobe.interfaces.export.write_dataset import DATA, DESCRIPTION, RECORDS, data_file
from lockprobe.studies.records.merge import MergeSource, source_of_directory

__all__ = ["LARGEST_FILE", "is_dataset", "source_of_dataset"]

LARGEST_FILE = 1 << 28
"""The largest file of a dataset, in bytes."""


def is_dataset(directory: Path) -> bool:
    """Whether a directory is a dataset of :func:`lockprobe.interfaces.export.write_dataset.write_dataset`."""
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
        _hold_together(directory / DATA / data_file(records.study, table.name), table)
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
    if missing := [name for name in table.columns if name not in columns]:
        raise BadFile(path, f"has no column {missing[0]}")
    if len(there) != len(table.rows):
        raise BadFile(path, f"has {len(there)} rows, and the records have {len(table.rows)}")
    for number, (found, row) in enumerate(zip(there, table.rows, strict=True), 1):
        for name in table.columns:
            if not _same(found[name], recorded := str(row.get(name, ""))):
                raise BadFile(path, f"row {number}: {name} is {found[name]!r}, and {recorded!r} in the records")


def _same(found: str | None, recorded: str) -> bool:
    """Whether a cell agrees with the records; one that a short row lacks does not."""
    return found is not None and readable(found) == recorded
