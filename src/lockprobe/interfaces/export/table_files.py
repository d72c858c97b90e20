"""Writes tables as files: CSV, JSON lines, Parquet, each with a file that holds its data dictionary."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import IO, Literal

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.foundation.terminal_text import one_line
from lockprobe.interfaces.export.data_dictionary import as_bits, column, dictionary
from lockprobe.interfaces.export.tidy import TidyCell, tidy_columns, tidy_rows, trial_columns, trial_rows
from lockprobe.trial.record import Trial

FileKind = Literal["csv", "jsonl", "parquet"]

_FORMULA = ("=", "+", "-", "@", "\t", "\n")
"""Beginnings of cells that a spreadsheet reads as formulas."""


@dataclass(frozen=True, slots=True)
class Rows:
    """A table whose rows can be iterated once.

    Attributes:
        about: The description of a row.
        columns: Names of the columns, in order.
        rows: Cells by column; empty texts for missing values.
    """

    about: str
    columns: tuple[str, ...]
    rows: Iterable[Mapping[str, TidyCell]]


def rows_of(name: Literal["steps", "trials"], trials: Sequence[Trial]) -> Rows:
    """Trials as a table with one row per step or per trial."""
    if name == "trials":
        return Rows("One row per trial.", trial_columns(trials), trial_rows(trials))
    return Rows("One row per step, truth and report.", tidy_columns(trials), tidy_rows(trials))


def write_table(table: Rows, path: Path, kind: FileKind) -> list[Path]:
    """Write a table and its data dictionary (``NAME-metadata.json``), both or neither, and return both paths.

    Raises:
        Missing: If Parquet is asked for and pyarrow is not installed.
        BadFile: If a file cannot be written, or is no regular file.
    """
    beside = path.parent / f"{path.name}-metadata.json"
    described = dictionary(path.name, table.columns, table.about)
    with atomic_files(beside, path) as (beside_draft, draft):
        beside_draft.write_text(json.dumps(described, indent=2, ensure_ascii=False) + "\n", "utf-8")
        if kind == "parquet":
            _write_parquet(table, draft)
        else:
            with draft.open("w", encoding="utf-8", newline="") as file:
                write_rows(table, file, kind)
    return [path, beside]


def write_rows(table: Rows, file: IO[str], kind: Literal["csv", "jsonl"]) -> None:
    """Write a table as CSV or as one JSON object per line, into a file that is open for text.

    CSV has a header line, configurations with ``b`` in front (``b0110``), and no cell that a spreadsheet takes for a
    formula.
    """
    if kind == "jsonl":
        file.writelines(one_line(json.dumps(row, ensure_ascii=False).encode()).decode() + "\n" for row in table.rows)
        return
    cells = {"text": _no_formula, "bits": as_bits}
    texts = {name: cells[of] for name in table.columns if (of := column(name).kind) in cells}
    rows = ({**row, **{name: cell(str(row[name])) for name, cell in texts.items()}} for row in table.rows)
    writer = csv.DictWriter(file, table.columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)


def _no_formula(text: str) -> str:
    """A text with one kind of line end, and an apostrophe in front of what looks like a formula and is no number."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if not text.startswith(_FORMULA):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text


def _write_parquet(table: Rows, draft: Path) -> None:
    try:
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        raise Missing("Parquet needs the package pyarrow", "pip install 'lockprobe[parquet]'") from None
    kinds = {"integer": arrow.int64(), "number": arrow.float64(), "text": arrow.string(), "bits": arrow.string()}
    about = {name: column(name) for name in table.columns}
    schema = arrow.schema(
        [
            arrow.field(name, kinds[one.kind], metadata={"description": one.meaning, "unit": one.unit})
            for name, one in about.items()
        ]
    )
    numbers = [name for name, one in about.items() if kinds[one.kind] != arrow.string()]
    rows = [{**row, **{name: None for name in numbers if row[name] == ""}} for row in table.rows]
    parquet.write_table(arrow.Table.from_pylist(rows, schema=schema), draft)
