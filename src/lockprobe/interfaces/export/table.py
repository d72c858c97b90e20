"""Tables of columns, each of which says what stands in it and where a row has it, and the files that hold them.

A file is CSV, JSON lines or Parquet; beside it stands its data dictionary.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Literal

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.foundation.terminal_text import one_line, readable

FileKind = Literal["csv", "jsonl", "parquet"]

Cell = str | int | float
"""An empty text where a value is missing."""

Kind = Literal["text", "integer", "number", "bits"]
"""The type of a cell. ``bits`` have one character per joint, 0, 1 or ?: a text whose leading zeros count."""

_DATATYPE: Mapping[Kind, str] = {"text": "string", "bits": "string", "integer": "integer", "number": "number"}

_FORMULA = ("=", "+", "-", "@", "\t", "\n")
"""Beginnings of cells that a spreadsheet reads as formulas."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column.

    Attributes:
        name: Its name.
        get: Its value in a row; None or an empty text if it is missing.
        meaning: The meaning of its values.
        kind: The type of its cells.
        unit: Its unit; empty for names, texts and marks.
        least: The smallest possible value; None if it holds no number.
        most: The largest possible value; None if there is no bound.
        optional: Whether it is left out where no row has a value.
    """

    name: str
    get: Callable[[Any], Cell | None]
    meaning: str
    kind: Kind = "text"
    unit: str = ""
    least: float | None = None
    most: float | None = None
    optional: bool = False

    def cell(self, row: object) -> Cell:
        """Its cell in a row: a mark as 1 or 0, a text without what would steer a terminal."""
        value = self.get(row)
        if isinstance(value, str):
            return readable(value)
        return "" if value is None else int(value) if isinstance(value, bool) else value


def text(name: str, meaning: str, get: Callable[[Any], Cell | None], **more: Any) -> Column:
    """A column of texts."""
    return Column(name=name, get=get, meaning=meaning, **more)


def mark(name: str, meaning: str, get: Callable[[Any], Cell | None], **more: Any) -> Column:
    """A column of ones and zeros."""
    return Column(name=name, get=get, meaning=f"1 or 0: {meaning}", kind="integer", least=0, most=1, **more)


def count(name: str, meaning: str, get: Callable[[Any], Cell | None], *, least: float = 1, **more: Any) -> Column:
    """A column of whole numbers."""
    return Column(name=name, get=get, meaning=meaning, kind="integer", least=least, **more)


def number(name: str, meaning: str, get: Callable[[Any], Cell | None], unit: str = "", **more: Any) -> Column:
    """A column of numbers from 0."""
    return Column(name=name, get=get, meaning=meaning, kind="number", unit=unit, least=0, **more)


class Table:
    """A table: columns over rows.

    Args:
        about: The description of a row.
        columns: Its columns; optional ones without a value in any row are left out.
        rows: Gives all rows, as often as it is called.
    """

    def __init__(self, about: str, columns: Iterable[Column], rows: Callable[[], Iterable[object]]) -> None:
        self.about, self._rows = f"A row is {about}.", rows
        self.columns = tuple(
            one for one in columns if not one.optional or any(one.cell(row) != "" for row in self._rows())
        )

    def rows(self) -> Iterator[dict[str, Cell]]:
        """The cells of each row by column."""
        return ({one.name: one.cell(row) for one in self.columns} for row in self._rows())

    def dictionary(self, file: str) -> dict[str, object]:
        """The data dictionary of the table in a file (W3C, CSV on the Web)."""
        columns = []
        for one in self.columns:
            bounds = {"minimum": one.least, "maximum": one.most}
            datatype = {"base": _DATATYPE[one.kind]} | {fact: end for fact, end in bounds.items() if end is not None}
            about = {"name": one.name, "titles": one.name, "dc:description": one.meaning, "datatype": datatype}
            columns.append(about | ({"schema:unitText": one.unit} if one.unit else {}))
        return {
            "@context": "http://www.w3.org/ns/csvw",
            "url": file,
            "dc:description": self.about,
            "tableSchema": {"columns": columns},
        }

    def write(self, path: Path, kind: FileKind) -> list[Path]:
        """Write the table and its data dictionary (``NAME-metadata.json``), both or neither, and return both paths.

        Raises:
            Missing: If Parquet is asked for and pyarrow is not installed.
            BadFile: If a file cannot be written, or is no regular file.
        """
        beside = path.parent / f"{path.name}-metadata.json"
        with atomic_files(beside, path) as (beside_draft, draft):
            beside_draft.write_text(
                json.dumps(self.dictionary(path.name), indent=2, ensure_ascii=False) + "\n", "utf-8"
            )
            if kind == "parquet":
                self._write_parquet(draft)
            else:
                with draft.open("w", encoding="utf-8", newline="") as file:
                    self.write_text(file, kind)
        return [path, beside]

    def write_text(self, file: IO[str], kind: Literal["csv", "jsonl"]) -> None:
        """Write CSV or one JSON object per line into a file that is open for text.

        CSV has a header line, configurations with ``b`` in front (``b0110``), so that no program reads them as numbers,
        and no cell that a spreadsheet takes for a formula.
        """
        if kind == "jsonl":
            lines = (json.dumps(row, ensure_ascii=False).encode() for row in self.rows())
            file.writelines(one_line(line).decode() + "\n" for line in lines)
            return
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([one.name for one in self.columns])
        writer.writerows([_for_csv(one, row[one.name]) for one in self.columns] for row in self.rows())

    def _write_parquet(self, draft: Path) -> None:
        try:
            arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
        except ImportError:
            raise Missing("Parquet needs the package pyarrow", "pip install 'lockprobe[parquet]'") from None
        kinds = {"integer": arrow.int64(), "number": arrow.float64(), "text": arrow.string(), "bits": arrow.string()}
        fields = [
            arrow.field(one.name, kinds[one.kind], metadata={"description": one.meaning, "unit": one.unit})
            for one in self.columns
        ]
        numbers = [one.name for one in self.columns if one.kind in ("integer", "number")]
        rows = [{**row, **{name: None for name in numbers if row[name] == ""}} for row in self.rows()]
        parquet.write_table(arrow.Table.from_pylist(rows, schema=arrow.schema(fields)), draft)


def _for_csv(column: Column, cell: Cell) -> Cell:
    if column.kind == "bits":
        return f"b{cell}" if cell else ""
    if column.kind != "text" or not isinstance(cell, str):
        return cell
    plain = cell.replace("\r\n", "\n").replace("\r", "\n")
    if not plain.startswith(_FORMULA):
        return plain
    try:
        float(plain)
    except ValueError:
        return f"'{plain}"
    return plain
