"""The downloads of a study's admin page: the dataset as one ZIP file, each of its tables, and data dictionaries.

Tables and dataset are those of ``lockprobe export --format psych-ds``: without platform IDs, tokens, times of day and
data of participants who have withdrawn.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from lockprobe.interfaces.export.data_dictionary import dictionary
from lockprobe.interfaces.export.tables import TABLES, PeopleRecords, Table, tables_of
from lockprobe.interfaces.export.write_dataset import as_csv, shareable, write_dataset

__all__ = ["DATASET", "Download", "downloads"]

DATASET = "dataset.zip"

_SMALL_ALREADY = {".png"}
"""Endings of files that are already compressed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Download:
    """One file to download.

    Attributes:
        name: The name of the file.
        about: Its content, in words.
        write: Writes the data so far into a file; can be sent to another process.
    """

    name: str
    about: str
    write: Callable[[Path], None]


def downloads(directory: Path) -> tuple[Download, ...]:
    """The downloads of the study in a directory: the dataset first, then each table and its data dictionary.

    Writing raises BadFile if a file in the directory is damaged, and for the dataset also if nobody took part.
    """
    whole = Download(
        name=DATASET,
        about="the whole dataset, with a description of every column",
        write=partial(_write_zip, directory),
    )
    tables = [
        download
        for name, row in TABLES.items()
        for download in (
            Download(name=f"{name}.csv", about=f"one row is {row}", write=partial(_write_table, directory, name)),
            Download(
                name=f"{name}.csv-metadata.json",
                about=f"the data dictionary of {name}.csv",
                write=partial(_write_dictionary, directory, name),
            ),
        )
    ]
    return (whole, *tables)


def _write_zip(directory: Path, file: Path) -> None:
    with TemporaryDirectory(prefix="lockprobe-") as place:
        dataset = Path(place) / "dataset"
        write_dataset(directory, dataset)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(path for path in dataset.rglob("*") if path.is_file()):
                how = zipfile.ZIP_STORED if path.suffix in _SMALL_ALREADY else None
                archive.write(path, path.relative_to(place), how)


def _table(directory: Path, name: str) -> Table:
    given = shareable(PeopleRecords.read(directory))
    return tables_of(given, (name,))[0]


def _write_table(directory: Path, name: str, file: Path) -> None:
    file.write_text(as_csv(_table(directory, name)), "utf-8", newline="")


def _write_dictionary(directory: Path, name: str, file: Path) -> None:
    described = dictionary(f"{name}.csv", _table(directory, name).columns, f"A row is {TABLES[name]}.")
    file.write_text(json.dumps(described, indent=2, ensure_ascii=False) + "\n", "utf-8")
