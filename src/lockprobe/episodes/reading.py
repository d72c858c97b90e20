"""Files of episodes, read as data: CSV, JSON lines, Parquet, and logs of Inspect through its own reader.

A file comes from anywhere: it is read with limits, and a mistake in it is one line that says where it is, what came and
what was expected.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.episodes.columns import TEXTS, ColumnMap
from lockprobe.episodes.frame import Array, Codes, Episodes, combined, position
from lockprobe.foundation.errors import BadFile, UnknownName, needing
from lockprobe.foundation.inputs import LARGEST_INPUT, read_input

MOST_ROWS, MOST_NAMES = 1_000_000, 30
"""Rows of all files; agents, and conditions, that one page compares."""

_LONGEST = 1000
"""Characters of a name."""

_MARKS: Mapping[Any, Any] = {"true": 1, "false": 0}

Rows = Iterator[tuple[int, Mapping[str, Any]]]
"""The number of a line, and its cells by column; an empty one is None, an empty text, or not there."""


class _Table:
    """The cells of our columns, of all files together, with the file and the line of each row."""

    def __init__(self, columns: ColumnMap) -> None:
        self.columns, self.places = columns, list[tuple[Path, int]]()
        self.cells, self.names = dict[str, list[Any]](), dict[str, None]()

    def take(self, path: Path, rows: Rows) -> None:
        """Add the rows of a file."""
        same, columns = dict[str, str](), self.columns
        for number, row in rows:
            if len(self.places) == MOST_ROWS:
                raise BadFile(path, f"line {number}: got more than {MOST_ROWS} rows, expected at most so many")
            self.names.update(dict.fromkeys(row))
            for name, theirs in columns.names.items():
                if (cell := columns.constants.get(name) or row.get(theirs)) not in (None, ""):
                    cells = self.cells.setdefault(name, [])
                    cells += [None] * (len(self.places) - len(cells))
                    cells.append(same.setdefault(cell, cell) if isinstance(cell, str) else cell)
            self.places.append((path, number))

    def column(self, name: str) -> list[Any]:
        """The cells of a column, None where one is empty."""
        cells = self.cells.get(name, [])
        return cells + [None] * (len(self.places) - len(cells))

    def bad(self, row: int, column: str, expected: str) -> BadFile:
        """What is wrong with a cell."""
        (path, line), came = self.places[row], repr(self.cells[column][row])
        came = came if len(came) <= _LONGEST else f"{came[:20]}… ({len(came)} characters)"
        return BadFile(path, f"line {line}, column {self.columns.names[column]}: got {came}, expected {expected}")

    def texts(self, column: str) -> tuple[Codes, list[str]]:
        """The place of each row's name, and the names, as they come; that of an empty cell is empty."""
        index, found = dict[str, int](), np.zeros(len(self.places), dtype=np.int64)
        for row, cell in enumerate(self.column(column)):
            name = "" if cell is None else str(cell)
            if isinstance(cell, list | dict) or len(name) > _LONGEST:
                raise self.bad(row, column, f"a text of at most {_LONGEST} characters")
            found[row] = index.setdefault(name, len(index))
        return found, [*index]

    def numbers(self, column: str, expected: str, allowed: Callable[[Array], Any]) -> Array:
        """Numbers, NaN where a cell is empty; scores from 0 to 1."""
        found, (low, high) = np.full(len(self.places), np.nan), self.columns.scale if column == "score" else (0.0, 1.0)
        for row, cell in enumerate(self.column(column)):
            if cell is not None:
                try:
                    value = float(_MARKS.get(cell.lower(), cell) if isinstance(cell, str) else cell)
                except (TypeError, ValueError, OverflowError):
                    value = np.inf
                found[row] = (value - low) / (high - low) if np.isfinite(value) else np.inf
        for row in np.flatnonzero(~np.isnan(found) & ~allowed(found)).tolist():
            raise self.bad(row, column, expected)
        return found

    def actions(self) -> list[tuple[str, ...]]:
        """What each row's episode did: a JSON list, or words."""
        found, same = [], dict[str, str]()
        for row, cell in enumerate(self.column("actions")):
            given = cell.split() if isinstance(cell, str) and not cell.startswith("[") else cell or []
            try:
                given = json.loads(given) if isinstance(given, str) else given
            except (ValueError, RecursionError):
                given = None
            if not isinstance(given, list) or any(isinstance(one, list | dict) for one in given):
                raise self.bad(row, "actions", "a JSON list of texts, or words with spaces between")
            found.append(tuple(same.setdefault(one, one) for one in map(str, given)))
        return found

    def once(self, key: Codes, what: str) -> None:
        """Refuse two rows of one key: of one ``what``."""
        for row in np.flatnonzero(position(key))[:1].tolist():
            (path, line), (_, earlier) = self.places[row], self.places[int(np.argmax(key == key[row]))]
            more = " (a column episode tells several of one seed apart)" * (what == "episode")
            raise BadFile(path, f"line {line}: got the {what} of line {earlier} again, expected each once{more}")


def read_episodes(paths: Sequence[Path], columns: ColumnMap) -> Episodes:
    """The episodes of one or several files; the lines of Parquet and of logs are their rows, from 1.

    Raises:
        BadFile: If a file is too large, is not what its name says or holds no episode, or a cell is not what its column
            has to have, or an episode or a step is there twice.
        UnknownName: If a column that the map names is not there, or no condition is called as its control.
        Missing: If what reads the file is not installed.
    """
    table = _Table(columns)
    for path in paths:
        kind = ".eval" if columns.inspect else path.suffix
        if kind not in _READERS:
            raise BadFile(path, f"expected a name that ends in {', '.join(_READERS)}")
        table.take(path, _READERS[kind](path))
    if not table.places:
        raise BadFile(paths[0], "got no row, expected an episode")
    for name in columns.asked - columns.constants.keys():
        if columns.names[name] not in table.names:
            raise UnknownName(f"column of {paths[0]}", columns.names[name], table.names)
    return _made(table, columns.control)


def _text(path: Path) -> str:
    content = read_input(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = content.count(b"\n", 0, error.start) + 1, content[error.start]
        raise BadFile(path, f"line {line}: got the byte {byte:#04x}, expected text in UTF-8") from None


def _csv_rows(path: Path) -> Rows:
    """Rows below a line of names; a first line after ``#``, as monitors of Gymnasium write one, is left out."""
    reader, header = csv.reader(io.StringIO(_text(path), newline=""), strict=True), list[str]()
    try:
        for row in reader:
            if not header and not "".join(row[:1]).startswith("#"):
                header = row
                if len({*header}) < len(header):
                    raise BadFile(path, f"line {reader.line_num}: got a column twice, expected names that differ")
            elif header and row:
                if len(row) != len(header):
                    raise BadFile(path, f"line {reader.line_num}: got {len(row)} cells, expected {len(header)}")
                yield reader.line_num, dict(zip(header, row, strict=True))
    except csv.Error as error:
        raise BadFile(path, f"line {reader.line_num}: not CSV ({error})") from None


def _json_rows(path: Path) -> Rows:
    for number, line in enumerate(_text(path).split("\n"), 1):
        if line.strip():
            try:
                row = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise BadFile(path, f"line {number}: not JSON ({error})") from None
            if not isinstance(row, dict):
                raise BadFile(path, f"line {number}: got {line[:20]!r}, expected a JSON object")
            yield number, row


def _parquet_rows(path: Path) -> Rows:
    content = read_input(path)
    with needing("Parquet files", "parquet"):
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    try:
        file = parquet.ParquetFile(io.BytesIO(content))
        groups = [file.metadata.row_group(i) for i in range(file.metadata.num_row_groups)]
        if file.metadata.num_rows > MOST_ROWS or sum(one.total_byte_size for one in groups) > LARGEST_INPUT:
            raise BadFile(path, f"expected at most {MOST_ROWS} rows, and {LARGEST_INPUT} bytes when it is unpacked")
        rows = file.read().to_pylist()
    except (arrow.ArrowException, OSError) as error:
        raise BadFile(path, f"not Parquet ({error})") from None
    yield from enumerate(rows, 1)


def _logged(path: Path) -> Rows:
    from lockprobe.interfaces.inspect import logged_samples

    yield from enumerate(logged_samples(path), 1)


_READERS = {".csv": _csv_rows, ".jsonl": _json_rows, ".parquet": _parquet_rows, ".eval": _logged}


def _made(table: _Table, control: str) -> Episodes:
    """The episodes of the rows, which are of one each, or of one step each if they have an action or a step."""
    coded = {name: table.texts(name) for name in TEXTS}
    for name in ("agent", "condition"):
        if len(names := coded[name][1]) > MOST_NAMES:
            raise BadFile(table.places[0][0], f"column {name}: got {len(names)} names, expected at most {MOST_NAMES}")
    conditions = coded["condition"][1]
    if control and control not in conditions:
        raise UnknownName("condition of the episodes", control, conditions)
    solved = table.numbers("solved", "0 or 1, or true or false", lambda x: (x == 0) | (x == 1))
    score = table.numbers("score", "a number from 0 to 1, or a map with low and high", lambda x: (x >= 0) & (x <= 1))
    steps = table.numbers("steps", "a whole number from 0", lambda x: (x >= 0) & (x < 1e9) & (x == np.floor(x)))
    key = combined(*(codes for codes, _ in coded.values()))
    if table.cells.keys() & {"step", "action"}:
        first, solved, score, steps, actions = _joined(table, key, solved, score)
    else:
        first, actions = np.arange(len(key)), table.actions()
        if table.cells.keys() & {"seed", "episode"}:
            table.once(key, "episode")
        steps = np.where(np.isnan(steps), [len(did) or np.nan for did in actions], steps)
    if np.isnan(solved).all() and np.isin(score[~np.isnan(score)], (0, 1)).all():
        solved, score = score, solved
    agent, condition, task, seed = (coded[name][0][first] for name in TEXTS[:4])
    seeded = np.array([cell is not None for cell in table.column("seed")])[first]
    luck = np.where(seeded, combined(task, seed), -1)
    order = sorted(range(len(conditions)), key=lambda i: conditions[i] != (control or conditions[0]))
    return Episodes(
        agents=coded["agent"][1],
        conditions=[conditions[i] for i in order],
        tasks=coded["task"][1],
        agent=agent,
        condition=np.argsort(order)[condition],
        task=task,
        luck=luck,
        rank=position(combined(agent, condition, luck + 1)),
        solved=solved,
        score=score,
        steps=steps,
        actions=actions,
    )


def _joined(
    table: _Table, key: Codes, solved: Array, score: Array
) -> tuple[Codes, Array, Array, Array, list[tuple[str, ...]]]:
    """The episodes of rows of steps: the first row of each, whether any row says solved, its last score, its steps."""
    number = table.numbers("step", "a number", np.isfinite)
    if "step" in table.cells:
        table.once(combined(key, np.unique(number, return_inverse=True)[1].reshape(-1)), "step")
    order = np.lexsort((np.where(np.isnan(number), np.arange(len(key)), number), key))
    steps, known = np.bincount(key), np.bincount(key, ~np.isnan(solved)) > 0
    scored, last = order[~np.isnan(score[order])], np.full(len(steps), np.nan)
    last[key[scored]] = score[scored]  # of several the last one stays
    did = np.array([str(action) for action in table.column("action")], dtype=object)[order]
    split = np.split(did, np.cumsum(steps)[:-1]) if "action" in table.cells else [()] * len(steps)
    once = np.where(known, np.bincount(key, solved == 1) > 0, np.nan)
    return np.unique(key, return_index=True)[1], once, last, steps.astype(np.float64), [*map(tuple, split)]
