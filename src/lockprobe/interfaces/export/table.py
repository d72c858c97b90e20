"""Tables whose columns ``columns.toml`` describes, and the files that hold them.

A file is CSV, JSON lines or Parquet; beside it stands its data dictionary.
"""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Literal

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.foundation.terminal_text import one_line, readable

Cell = str | int | float
"""An empty text where a value is missing."""

_DATATYPES: Mapping[str, dict[str, Any]] = {
    "text": {"base": "string"},
    "bits": {"base": "string"},
    "mark": {"base": "integer", "minimum": 0, "maximum": 1},
    "count": {"base": "integer", "minimum": 1},
    "number": {"base": "number", "minimum": 0},
}
"""Kind of a column -> the type of its cells (W3C, CSV on the Web), if it says nothing else."""

_FORMULA = ("=", "+", "-", "@", "\t", "\n")
"""Beginnings of cells that a spreadsheet reads as formulas."""


@cache
def _described() -> Mapping[str, Mapping[str, Any]]:
    return tomllib.loads(Path(__file__).with_name("columns.toml").read_text("utf-8"))


class Table:
    """A table: columns over rows.

    Args:
        name: Its name in ``columns.toml``.
        rows: Gives all rows, as often as it is called: the values by column, None where one is missing.
        more: Further columns, described as there.

    Attributes:
        columns: Its columns, each with what describes it; optional ones without a value in any row are left out.
    """

    def __init__(
        self,
        name: str,
        rows: Callable[[], Iterable[Mapping[str, object]]],
        more: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        described = _described()
        self._about, self._rows = f"A row is {described['rows'][name]}.", rows
        shared = ("trial", name, "person") if name in ("steps", "trials") else (name,)
        columns = {column: facts for part in shared for column, facts in described[part].items()} | dict(more or {})
        left = {column for column, facts in columns.items() if facts.get("optional")}
        for row in rows() if left else ():
            left -= {column for column in left if _cell(row.get(column)) != ""}
        self.columns: Mapping[str, Mapping[str, Any]] = {
            column: {"kind": "text", **facts} for column, facts in columns.items() if column not in left
        }

    def rows(self) -> Iterator[dict[str, Cell]]:
        """The cells of each row by column: a mark as 1 or 0, a text without what would steer a terminal."""
        return ({column: _cell(row.get(column)) for column in self.columns} for row in self._rows())

    def dictionary(self, file: str) -> dict[str, object]:
        """The data dictionary of the table in a file (W3C, CSV on the Web)."""
        described = [
            {
                "name": column,
                "titles": column,
                "dc:description": _meaning(facts),
                "datatype": _DATATYPES[facts["kind"]]
                | {bound: facts[bound] for bound in ("minimum", "maximum") if bound in facts},
            }
            | ({"schema:unitText": facts["unit"]} if "unit" in facts else {})
            for column, facts in self.columns.items()
        ]
        return {
            "@context": "http://www.w3.org/ns/csvw",
            "url": file,
            "dc:description": self._about,
            "tableSchema": {"columns": described},
        }

    def write(self, path: Path, kind: Literal["csv", "jsonl", "parquet"]) -> list[Path]:
        """Write the table and its data dictionary (``NAME-metadata.json``), both or neither, and return both paths.

        Raises:
            Missing: If Parquet is asked for and pyarrow is not installed.
            BadFile: If a file cannot be written, or is no regular file.
        """
        beside = path.parent / f"{path.name}-metadata.json"
        with atomic_files(beside, path) as (beside_draft, draft):
            dictionary = json.dumps(self.dictionary(path.name), indent=2, ensure_ascii=False)
            beside_draft.write_text(f"{dictionary}\n", "utf-8")
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
        writer.writerow(self.columns)
        kinds = [facts["kind"] for facts in self.columns.values()]
        writer.writerows(map(_for_csv, kinds, row.values()) for row in self.rows())

    def _write_parquet(self, draft: Path) -> None:
        try:
            arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
        except ImportError:
            raise Missing("Parquet needs the package pyarrow", "pip install 'lockprobe[parquet]'") from None
        kinds = {"integer": arrow.int64(), "number": arrow.float64(), "string": arrow.string()}
        bases = {column: _DATATYPES[facts["kind"]]["base"] for column, facts in self.columns.items()}
        fields = [
            arrow.field(
                column, kinds[bases[column]], metadata={"description": _meaning(facts), "unit": facts.get("unit", "")}
            )
            for column, facts in self.columns.items()
        ]
        rows = [
            {column: None if cell == "" and bases[column] != "string" else cell for column, cell in row.items()}
            for row in self.rows()
        ]
        parquet.write_table(arrow.Table.from_pylist(rows, schema=arrow.schema(fields)), draft)


def _cell(value: Any) -> Cell:
    if isinstance(value, str):
        return readable(value)
    return "" if value is None else int(value) if isinstance(value, bool) else value


def _meaning(facts: Mapping[str, Any]) -> str:
    return f"1 or 0: {facts['meaning']}" if facts["kind"] == "mark" else str(facts["meaning"])


def _for_csv(kind: str, cell: Cell) -> Cell:
    if kind == "bits":
        return f"b{cell}" if cell else ""
    if not isinstance(cell, str):
        return cell
    plain = cell.replace("\r\n", "\n").replace("\r", "\n")
    if not plain.startswith(_FORMULA):
        return plain
    try:
        float(plain)
    except ValueError:
        return f"'{plain}"
    return plain
