"""Files of episodes, read as data: CSV, JSON lines, Parquet, and logs of Inspect through its own reader.

A file comes from anywhere: it is read with limits, and a mistake in it is one line that says where it is, what came and
what was expected. Which column is which says a preset, or a TOML file: ``agent = "model_name"`` names the column of the
file, ``condition = { constant = "plain" }`` gives all rows one value, ``preset`` begins from names of a benchmark.
"""

from __future__ import annotations

import csv
import io
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.foundation.errors import BadFile, UnknownName, needing
from lockprobe.foundation.inputs import LARGEST_INPUT, read_input, read_toml
from lockprobe.interfaces.episodes.frame import Array, Codes, Episodes, combined, position

MOST_ROWS, MOST_NAMES, _LONGEST, _MOST_VALUES = 1_000_000, 30, 1000, 1 << 25
"""Rows of all files; agents, and conditions, that one page compares; characters of a name; values in Parquet."""

PRESETS = {
    "inspect": "",
    "balrog": "agent=model_id condition=agent steps=num_steps score=progression step=Step action=Action",
    "gymnasium": "score=r steps=l",
}
"""Names of columns that are not ours, in tables like BALROG's and by ``RecordEpisodeStatistics``; a log of Inspect is
read into ours. A file may lack some."""

Rows = Iterator[tuple[int, Mapping[str, Any]]]
"""The number of a line, and its cells by column; an empty one is None, an empty text, or not there."""


@lru_cache(100_000, typed=True)  # most cells come again and again; a list is refused because it cannot be kept
def _name(cell: Any) -> str:
    if len(name := str(cell)) > _LONGEST or not name.encode():  # half of a surrogate pair cannot be written
        raise ValueError
    return sys.intern(name)


@lru_cache(100_000, typed=True)
def _number(cell: Any, *, most: float = 1.0, whole: bool = False) -> float:
    words = {"true": 1, "yes": 1, "false": 0, "no": 0}
    value = float(words.get(cell.lower(), cell) if isinstance(cell, str) else cell)
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

_TEXTS = ("agent", "condition", "task", "seed", "episode")
"""Columns that say which episode a row is of, or is part of."""

COLUMNS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    **dict.fromkeys((*_TEXTS, "action", "told"), _TEXT),
    "step": (partial(_number, most=1e9), "a number from 0"),
    **dict.fromkeys(("solved", "told_falsely"), (partial(_number, whole=True), "0 or 1, true or false, yes or no")),
    "score": (_number, "a number from 0 to 1"),
    "steps": (partial(_number, most=1e9, whole=True), "a whole number from 0"),
    "actions": (_actions, "a JSON list of texts, or words with spaces between"),
}
"""All columns that a file may have, under these names or others: what their cells are read with, and have to be."""


def read_episodes(paths: Sequence[Path], asked: str = "") -> Episodes:
    """The episodes of all files together; ``asked`` is the preset or TOML file that says which column is which.

    Lines of Parquet and of logs are their rows, from 1.

    Raises:
        BadFile: If a file is too large, is not what its name says, has no known column or holds no episode, or a cell
            is not what its column has to have, or an episode or a step is there twice, or a step is missing.
        UnknownName: If a preset, a column of ours, or one that is named of the file, does not exist.
        Missing: If what reads the file is not installed.
    """
    names, constants, named, hoped = _mapped(asked)
    cells, places, every = {name: list[Any]() for name in COLUMNS}, list[tuple[Path, int]](), dict[str, Any]()
    columns = [(cells[name], names[name], constants.get(name), kind) for name, kind in COLUMNS.items()]
    for path in paths:
        if path.suffix not in _READERS:
            raise BadFile(path, f"expected a name that ends in {', '.join(_READERS)}")
        there, began = dict[str, Any](), len(places)
        for number, row in _READERS[path.suffix](path):
            if len(places) == MOST_ROWS:
                raise BadFile(path, f"line {number}: got more than {MOST_ROWS} rows, expected at most so many")
            there |= row
            places.append((path, number))
            for own, column, constant, (parse, expected) in columns:
                cell = constant or row.get(column)
                try:
                    own.append(None if cell is None or cell == "" else parse(cell))
                except (TypeError, ValueError, OverflowError, RecursionError):
                    said = f"line {number}, column {column}: got {cell!r:.80}, expected {expected}"
                    raise BadFile(path, said) from None
        every |= there
        fewest = 1 if len(hoped) == len(COLUMNS) else 2  # one of a preset may be there by chance
        if len(places) > began and len(there.keys() & hoped) < fewest:
            expected = f"{fewest} or more of {', '.join(hoped)}; --map says which column is which"
            raise BadFile(path, f"got the columns {', '.join(there)}, expected {expected}")
    if not places:
        raise BadFile(paths[0], "got no row, expected an episode")
    if missing := [name for name in named if name not in every]:
        raise UnknownName(f"column of {paths[0]}", missing[0], every)
    return _made(cells, places)


def _mapped(asked: str) -> tuple[dict[str, str], dict[str, str], list[str], list[str]]:
    """Our column -> that of the file; our column -> what all rows have; columns that are named; all, or a preset's."""
    written = {"preset": asked} if asked in PRESETS else read_toml(Path(asked)) if asked else {}
    if (preset := str(written.pop("preset", "inspect"))) not in PRESETS:
        raise UnknownName("preset", preset, PRESETS)
    own = dict(pair.split("=") for pair in PRESETS[preset].split())
    names = {name: name for name in COLUMNS} | own
    constants = dict[str, str]()
    for name, value in written.items():
        if name not in COLUMNS:
            raise UnknownName(f"column, or setting of {asked},", name, (*COLUMNS, "preset"))
        match value:
            case str():
                names[name] = value
            case {"constant": str() | int() | float() as constant}:
                constants[name] = str(constant)
            case _:
                raise BadFile(asked, f"{name}: got {value!r}, expected the name of a column, or {{ constant = VALUE }}")
    named = [value for value in written.values() if isinstance(value, str)]
    return names, constants, named, [names[name] for name in own or COLUMNS]


def _text(path: Path) -> str:
    content = read_input(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = content.count(b"\n", 0, error.start) + 1, content[error.start]
        raise BadFile(path, f"line {line}: got the byte {byte:#04x}, expected text in UTF-8") from None


def _csv_rows(path: Path) -> Rows:
    reader, most = csv.reader(io.StringIO(_text(path), newline=""), strict=True), csv.field_size_limit(LARGEST_INPUT)
    try:
        if len({*(names := next(reader, []))}) < len(names):
            raise BadFile(path, f"got a column twice, expected each once: {', '.join(names)}")
        for cells in filter(None, reader):
            if len(cells) != len(names):
                raise BadFile(path, f"line {reader.line_num}: got more or fewer cells than columns, expected one each")
            yield reader.line_num, dict(zip(names, cells, strict=True))
    except csv.Error as error:
        raise BadFile(path, f"line {reader.line_num}: not CSV ({error})") from None
    finally:
        csv.field_size_limit(most)


def _json_rows(path: Path) -> Rows:
    for number, line in enumerate(_text(path).split("\n"), 1):
        if line.strip():
            try:
                yield number, {**json.loads(line)}
            except (TypeError, ValueError, RecursionError) as error:
                raise BadFile(path, f"line {number}: not a JSON object ({error})") from None


def _parquet_rows(path: Path) -> Rows:
    content = read_input(path)
    with needing("Parquet files", "parquet"):
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    try:
        file = parquet.ParquetFile(io.BytesIO(content))
        if len({*(names := file.schema_arrow.names)}) < len(names):
            raise BadFile(path, f"got a column twice, expected each once: {', '.join(names)}")
        groups = [file.metadata.row_group(i) for i in range(file.metadata.num_row_groups)]
        parts = [group.column(i) for group in groups for i in range(group.num_columns)]
        rows, values = max(one.num_rows for one in (file.metadata, *groups)), sum(abs(one.num_values) for one in parts)
        size = sum(abs(one.total_uncompressed_size) for one in parts)
        if rows > MOST_ROWS or values > _MOST_VALUES or size > LARGEST_INPUT:
            said = f"{MOST_ROWS} rows, {_MOST_VALUES} cells, and {LARGEST_INPUT} bytes when it is unpacked"
            raise BadFile(path, f"expected at most {said}")
        yield from enumerate((row for batch in file.iter_batches(1000) for row in batch.to_pylist()), 1)
    except (arrow.ArrowException, OSError) as error:
        raise BadFile(path, f"not Parquet ({error})") from None


def _logged(path: Path) -> Rows:
    from lockprobe.interfaces.inspect import logged_samples

    yield from enumerate(logged_samples(path), 1)


_READERS = {".csv": _csv_rows, ".jsonl": _json_rows, ".parquet": _parquet_rows, ".eval": _logged}


def _made(cells: Mapping[str, list[Any]], places: Sequence[tuple[Path, int]]) -> Episodes:
    """The episodes of the rows, which are of one each, or of one step each if they have an action or a step."""
    names, coded = dict[str, list[str]](), dict[str, Codes]()
    for name in _TEXTS:
        own = {cell: i for i, cell in enumerate(dict.fromkeys(cells[name]))}
        names[name] = [cell or "(empty)" * (len(own) > 1) for cell in own]
        coded[name] = np.array([own[cell] for cell in cells[name]])
        if len(own) > MOST_NAMES and name in ("agent", "condition"):
            raise BadFile(places[0][0], f"column {name}: got {len(own)} names, expected at most {MOST_NAMES}")
    solved, score, steps, step = (np.array(cells[name], dtype=float) for name in ("solved", "score", "steps", "step"))
    there, key = {name for name, own in cells.items() if own.count(None) < len(own)}, combined(*coded.values())
    of_steps = bool(there & {"step", "action"})
    for row in np.flatnonzero(position(key))[:1].tolist() if not of_steps and there & {"seed", "episode"} else ():
        earlier = _line(places[int(np.argmax(key == key[row]))], places[row][0])
        said = f"got again the episode of {earlier} (a column episode tells several apart), expected each once"
        raise BadFile(places[row][0], f"line {places[row][1]}: {said}")
    first, actions = np.arange(len(key)), [did or () for did in cells["actions"]]
    if of_steps:
        step = step if "step" in there else position(key).astype(np.float64)
        order = np.lexsort((step, key))
        _refuse_gaps(key[order], step[order], [places[row] for row in order])
        first, solved, score, steps, actions = _joined(key, order, solved, score, cells["action"])
    steps = np.where(np.isnan(steps), [len(did) or np.nan for did in actions], steps)
    if np.isnan(solved).all() and np.isin(score[~np.isnan(score)], (0, 1)).all():
        solved, score = score, solved
    agent, condition, task, seed, _ = (column[first] for column in coded.values())
    luck = np.where(np.array([cell is not None for cell in cells["seed"]])[first], combined(task, seed), -1)
    return Episodes(
        agents=names["agent"], conditions=names["condition"], tasks=names["task"], agent=agent, condition=condition,
        task=task, luck=luck, rank=position(combined(agent, condition, luck + 1)), solved=solved, score=score,
        steps=steps, actions=actions,
    )  # fmt: skip


def _line(place: tuple[Path, int], here: Path) -> str:
    return f"line {place[1]}" + f" of {place[0]}" * (place[0] != here)


def _refuse_gaps(key: Codes, step: Array, places: Sequence[tuple[Path, int]]) -> None:
    """Refuse rows, in the order of episodes and steps, that do not follow on: loops and lengths would not be theirs."""
    same = np.r_[False, key[1:] == key[:-1]]
    due = np.where(same, np.r_[0, step[:-1]] + 1, np.fmin(step, 1))  # the first is 0 or 1
    for row in np.flatnonzero(step != due)[:1].tolist():
        path, line = places[row]
        after = f" after {_line(places[row - 1], path)}" * bool(same[row])
        expected = f"step {due[row]:g} (without a column of steps rows count as they come)"
        raise BadFile(path, f"line {line}: got step {step[row]:g} of an episode{after}, expected {expected}")


def _joined(
    key: Codes, order: Codes, solved: Array, score: Array, action: Sequence[str | None]
) -> tuple[Codes, Array, Array, Array, list[tuple[str, ...]]]:
    """The episodes of rows of steps: the first row of each, whether any row says solved, its last score, its steps.

    One whose last row does not say whether it is solved may have been cut off, and is unknown unless another says so.
    """
    steps = np.bincount(key)
    scored, last = order[~np.isnan(score[order])], np.full(len(steps), np.nan)
    last[key[scored]] = score[scored]  # of several the last one stays
    did, ends = [action[row] for row in order], np.cumsum(steps)
    parts = [tuple(filter(None, did[end - n : end])) for end, n in zip(ends, steps, strict=True)]
    once = np.fmax.reduceat(solved[order], ends - steps)
    once[np.isnan(solved[order][ends - 1]) & (once < 1)] = np.nan
    return np.unique(key, return_index=True)[1], once, last, steps.astype(np.float64), parts
