"""Files of episodes, read as data: CSV, JSON lines, Parquet, and logs of Inspect through its own reader.

A file comes from anywhere: it is read with limits, and a mistake in it is one line that says where it is, what came and
what was expected.
"""

from __future__ import annotations

import csv
import io
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.foundation.errors import BadFile, UnknownName, needing
from lockprobe.foundation.inputs import LARGEST_INPUT, read_input
from lockprobe.interfaces.episodes.columns import TEXTS, ColumnMap
from lockprobe.interfaces.episodes.frame import Array, Codes, Episodes, combined, position

MOST_ROWS, MOST_NAMES = 1_000_000, 30
"""Rows of all files; agents, and conditions, that one page compares."""

_LONGEST = 1000
"""Characters of a name."""

Rows = Iterator[tuple[int, Mapping[str, Any]]]
"""The number of a line, and its cells by column; an empty one is None, an empty text, or not there."""

Places = Sequence[tuple[Path, int]]
"""The file and the line of each row."""


def _name(cell: Any) -> str:
    if isinstance(cell, list | dict) or len(name := str(cell)) > _LONGEST:
        raise ValueError
    return sys.intern(name)


def _number(cell: Any, *, most: float = 1.0, whole: bool = False) -> float:
    """A number from 0 to ``most``."""
    value = float({"true": 1, "false": 0}.get(cell.lower(), cell) if isinstance(cell, str) else cell)
    if not 0 <= value <= most or (whole and value != int(value)):
        raise ValueError
    return value


def _actions(cell: Any) -> tuple[str, ...]:
    words = isinstance(cell, str) and not cell.startswith("[")
    given = cell.split() if words else json.loads(cell) if isinstance(cell, str) else cell
    if not isinstance(given, list):
        raise TypeError
    return tuple(map(_name, given))


_TEXT = _name, f"a text of at most {_LONGEST} characters"

_CELLS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    **dict.fromkeys(TEXTS, _TEXT),
    "step": (partial(_number, most=1e9), "a number from 0"),
    "action": _TEXT,
    "solved": (partial(_number, whole=True), "0 or 1, or true or false"),
    "score": (_number, "a number from 0 to 1"),
    "steps": (partial(_number, most=1e9, whole=True), "a whole number from 0"),
    "actions": (_actions, "a JSON list of texts, or words with spaces between"),
}
"""What the cells of a column are read with, and what they have to be."""


def read_episodes(paths: Sequence[Path], columns: ColumnMap) -> Episodes:
    """The episodes of one or several files; the lines of Parquet and of logs are their rows, from 1.

    Raises:
        BadFile: If a file is too large, is not what its name says or holds no episode, or a cell is not what its column
            has to have, or an episode or a step is there twice.
        UnknownName: If a column that the map names is not there.
        Missing: If what reads the file is not installed.
    """
    cells, places, names = {name: list[Any]() for name in _CELLS}, list[tuple[Path, int]](), dict[str, None]()
    for path in paths:
        kind = ".eval" if columns.inspect else path.suffix
        if kind not in _READERS:
            raise BadFile(path, f"expected a name that ends in {', '.join(_READERS)}")
        for number, row in _READERS[kind](path):
            if len(places) == MOST_ROWS:
                raise BadFile(path, f"line {number}: got more than {MOST_ROWS} rows, expected at most so many")
            names.update(dict.fromkeys(row))
            places.append((path, number))
            for name, (parse, expected) in _CELLS.items():
                cell = columns.constants.get(name) or row.get(columns.names[name])
                try:
                    cells[name].append(None if cell in (None, "") else parse(cell))
                except (TypeError, ValueError, OverflowError, RecursionError):
                    where = f"line {number}, column {columns.names[name]}"
                    raise BadFile(path, f"{where}: got {cell!r:.80}, expected {expected}") from None
    if not places:
        raise BadFile(paths[0], "got no row, expected an episode")
    for name in columns.asked:
        if columns.names[name] not in names:
            raise UnknownName(f"column of {paths[0]}", columns.names[name], names)
    return _made(cells, places)


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


def _made(cells: Mapping[str, list[Any]], places: Places) -> Episodes:
    """The episodes of the rows, which are of one each, or of one step each if they have an action or a step."""
    names = {name: [*dict.fromkeys(cell or "" for cell in cells[name])] for name in TEXTS}
    codes = {name: dict(zip(own, range(len(own)), strict=True)) for name, own in names.items()}
    coded = [np.array([codes[name][cell or ""] for cell in cells[name]]) for name in TEXTS]
    names = {name: [one or "(empty)" * (len(own) > 1) for one in own] for name, own in names.items()}
    for name in ("agent", "condition"):
        if len(names[name]) > MOST_NAMES:
            raise BadFile(places[0][0], f"column {name}: got {len(names[name])} names, expected at most {MOST_NAMES}")
    solved, score, steps, step = (np.array(cells[name], dtype=float) for name in ("solved", "score", "steps", "step"))
    there, key = {name for name, own in cells.items() if own.count(None) < len(own)}, combined(*coded)
    if there & {"step", "action"}:
        if "step" in there:
            _once(places, combined(key, np.unique(step, return_inverse=True)[1].reshape(-1)), "step")
        first, solved, score, steps, actions = _joined(key, step, solved, score, cells["action"])
    else:
        if there & {"seed", "episode"}:
            _once(places, key, "episode")
        first, actions = np.arange(len(key)), [did or () for did in cells["actions"]]
        steps = np.where(np.isnan(steps), [len(did) or np.nan for did in actions], steps)
    if np.isnan(solved).all() and np.isin(score[~np.isnan(score)], (0, 1)).all():
        solved, score = score, solved
    agent, condition, task, seed = (column[first] for column in coded[:4])
    seeded = np.array([cell is not None for cell in cells["seed"]])[first]
    luck = np.where(seeded, combined(task, seed), -1)
    return Episodes(
        agents=names["agent"],
        conditions=names["condition"],
        tasks=names["task"],
        agent=agent,
        condition=condition,
        task=task,
        luck=luck,
        rank=position(combined(agent, condition, luck + 1)),
        solved=solved,
        score=score,
        steps=steps,
        actions=actions,
    )


def _once(places: Places, key: Codes, what: str) -> None:
    """Refuse two rows of one key: of one ``what``."""
    for row in np.flatnonzero(position(key))[:1].tolist():
        (path, line), (_, earlier) = places[row], places[int(np.argmax(key == key[row]))]
        more = " (a column episode tells several of one seed apart)" * (what == "episode")
        raise BadFile(path, f"line {line}: got the {what} of line {earlier} again, expected each once{more}")


def _joined(
    key: Codes, step: Array, solved: Array, score: Array, action: Sequence[str | None]
) -> tuple[Codes, Array, Array, Array, list[tuple[str, ...]]]:
    """The episodes of rows of steps: the first row of each, whether any row says solved, its last score, its steps."""
    order = np.lexsort((np.where(np.isnan(step), np.arange(len(key)), step), key))
    steps, known = np.bincount(key), np.bincount(key, ~np.isnan(solved)) > 0
    scored, last = order[~np.isnan(score[order])], np.full(len(steps), np.nan)
    last[key[scored]] = score[scored]  # of several the last one stays
    did, ends = [action[row] for row in order], np.cumsum(steps)
    parts = [tuple(filter(None, did[end - n : end])) for end, n in zip(ends, steps, strict=True)]
    once = np.where(known, np.bincount(key, solved == 1) > 0, np.nan)
    return np.unique(key, return_index=True)[1], once, last, steps.astype(np.float64), parts
