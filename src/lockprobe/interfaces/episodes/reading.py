"""Files of episodes, read as data: CSV, JSON lines, Parquet, and logs of Inspect through its own reader.

A file comes from anywhere: it is read with limits, and a mistake in it is one line that says where it is, what came and
what was expected. Which column is which says a preset, or a TOML file: ``agent = "model_name"`` names the column of the
file, or ``agent = "file"`` what the file is called; ``preset`` begins from names of a benchmark.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

from lockprobe.foundation.errors import BadFile, UnknownName, needing
from lockprobe.foundation.inputs import LARGEST_INPUT, read_input, read_toml
from lockprobe.foundation.validation import plain
from lockprobe.interfaces.episodes.frame import Array, Codes, Episodes, combined, position

MOST_ROWS, MOST_NAMES, _MOST_VALUES = 1_000_000, 30, 1 << 25
"""Rows of all files; agents, and conditions, that one page compares; values in Parquet."""

_BALROG = {"agent": "model_id", "condition": "agent", "steps": "num_steps", "score": "progression"}

PRESETS = {
    "inspect": dict[str, str](),
    "balrog": _BALROG | {"step": "Step", "action": "Action"},
    "gymnasium": {"score": "r", "steps": "l"},
}
"""Names of columns that are not ours, in tables like BALROG's and by ``RecordEpisodeStatistics``; a log of Inspect is
read into ours. A file may lack some."""

Rows = Iterator[tuple[int, Mapping[str, Any]]]
"""The number of a line, and its cells by column; an empty one is None, an empty text, or not there."""

_OBJECT = TypeAdapter(dict[str, Any])


def _words(cell: object) -> object:
    """The actions of a cell: a list, its JSON, or words with spaces between."""
    if not isinstance(cell, str):
        return cell
    return from_json(cell) if cell.startswith("[") else cell.split()


_Text = Annotated[str, Field(max_length=1000)]
_Name = Annotated[_Text, BeforeValidator(lambda cell: cell if isinstance(cell, list | dict) else str(cell))]
_Truth = Annotated[bool, BeforeValidator(lambda cell: cell.removesuffix(".0") if isinstance(cell, str) else cell)]
_Whole = Annotated[int, Field(ge=0, le=10**9)]

NAMES = ("agent", "condition", "task", "seed", "episode")
"""Columns that say which episode a row is of, or is part of."""

_KINDS: dict[str, Any] = dict.fromkeys(NAMES, _Name) | {
    "solved": _Truth,
    "score": Annotated[float, Field(ge=0, le=1)],
    "steps": _Whole,
    "actions": Annotated[tuple[_Text, ...], BeforeValidator(_words)],
    "step": _Whole,
    "action": _Text,
}
COLUMNS = {name: TypeAdapter[Any](kind, config={"coerce_numbers_to_str": True}) for name, kind in _KINDS.items()}
"""All columns that a file may have, under these names or others, and what their cells have to be if not empty."""

FILE = "file"
"""A column that every file has: its own name."""


def read_episodes(paths: Sequence[Path], asked: str = "") -> Episodes:
    """The episodes of all files together; ``asked`` is the preset or TOML file that says which column is which.

    Lines of Parquet and of logs are their rows, from 1.

    Raises:
        BadFile: If a file is too large, is not what its name says, has no known column or holds no episode, or a cell
            is not what its column has to have, or an episode or a step is there twice, or a step is missing.
        UnknownName: If a preset, a column of ours, or one that is named of the file, does not exist.
        Missing: If what reads the file is not installed.
    """
    names, written = _mapped(asked)
    cells, places, every = {name: list[Any]() for name in COLUMNS}, list[tuple[Path, int]](), dict[str, Any]()
    for path in paths:
        if path.suffix not in _READERS:
            raise BadFile(path, f"expected a name that ends in {', '.join(_READERS)}")
        there = dict[str, Any]()
        for number, row in _READERS[path.suffix](path):
            if len(places) == MOST_ROWS:
                raise BadFile(path, f"line {number}: got more than {MOST_ROWS} rows, expected at most so many")
            there |= row
            places.append((path, number))
            named = {FILE: path.stem, **row}
            for ours, name in names.items():
                cell = named.get(name)
                try:
                    cells[ours].append(None if cell in (None, "") else COLUMNS[ours].validate_python(cell))
                except ValidationError as error:
                    wrong = error.errors()[0]
                    said = f"column {name}: got {wrong['input']!r:.80}, {plain(wrong['msg'])}"
                    raise BadFile(path, f"line {number}, {said}") from None
        if there and there.keys().isdisjoint(names.values()):
            expected = f"one or more of {', '.join(names.values())}; --map says which column is which"
            raise BadFile(path, f"got the columns {', '.join(there)}, expected {expected}")
        every |= there
    if not places:
        raise BadFile(paths[0], "got no row, expected an episode")
    if missing := [name for name in written.values() if name not in (FILE, *every)]:
        raise UnknownName(f"column of {paths[0]}", missing[0], every)
    return _made(cells, places)


def _mapped(asked: str) -> tuple[dict[str, str], dict[str, str]]:
    """Our column -> that of the file; those of them that are written down."""
    written: dict[str, Any] = {"preset": asked} if asked in PRESETS else read_toml(Path(asked)) if asked else {}
    if (preset := str(written.pop("preset", "inspect"))) not in PRESETS:
        raise UnknownName("preset", preset, PRESETS)
    for ours, name in written.items():
        if ours not in COLUMNS:
            raise UnknownName(f"column, or setting of {asked},", ours, (*COLUMNS, "preset"))
        if not isinstance(name, str):
            raise BadFile(asked, f"{ours}: got {name!r}, expected the name of a column")
    return {name: name for name in COLUMNS} | PRESETS[preset] | written, written


def _text(path: Path) -> str:
    content = read_input(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = content.count(b"\n", 0, error.start) + 1, content[error.start]
        raise BadFile(path, f"line {line}: got the byte {byte:#04x}, expected text in UTF-8") from None


def _refuse_doubled(path: Path, names: Collection[str]) -> None:
    if len({*names}) < len(names):
        raise BadFile(path, f"got a column twice, expected each once: {', '.join(names)}")


def _csv_rows(path: Path) -> Rows:
    reader = csv.DictReader(io.StringIO(_text(path), newline=""), strict=True)
    csv.field_size_limit(LARGEST_INPUT)  # one cell may hold all actions of an episode
    try:
        _refuse_doubled(path, reader.fieldnames or ())
        for row in reader:
            if None in row or None in row.values():
                raise BadFile(path, f"line {reader.line_num}: got more or fewer cells than columns, expected one each")
            yield reader.line_num, row
    except csv.Error as error:
        raise BadFile(path, f"line {reader.reader.line_num}: not CSV ({error})") from None


def _json_rows(path: Path) -> Rows:
    for number, line in enumerate(_text(path).split("\n"), 1):
        if line.strip():
            try:
                yield number, _OBJECT.validate_json(line)
            except ValidationError as error:
                raise BadFile(path, f"line {number}: not a JSON object ({error.errors()[0]['msg']})") from None


def _parquet_rows(path: Path) -> Rows:
    content = read_input(path)
    with needing("Parquet files", "parquet"):
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    try:
        file = parquet.ParquetFile(io.BytesIO(content))
        _refuse_doubled(path, file.schema_arrow.names)
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
    """The episodes of the rows, which are of one each, or of one step each if they have an action or a step.

    An episode of steps is solved if any row says so, and has its last score. One whose last row does not say whether it
    is solved may have been cut off, and is unknown unless another says so.
    """
    names, coded = dict[str, list[str]](), dict[str, Codes]()
    for name in NAMES:
        own = {cell: i for i, cell in enumerate(dict.fromkeys(cells[name]))}
        names[name] = [cell or "(empty)" * (len(own) > 1) for cell in own]
        coded[name] = np.array([own[cell] for cell in cells[name]])
        if len(own) > MOST_NAMES and name in ("agent", "condition"):
            raise BadFile(places[0][0], f"column {name}: got {len(own)} names, expected at most {MOST_NAMES}")
    solved, score, steps, step = (np.array(cells[name], dtype=float) for name in ("solved", "score", "steps", "step"))
    there, key = {name for name, own in cells.items() if own.count(None) < len(own)}, combined(*coded.values())
    if of_steps := not there.isdisjoint({"step", "action"}):
        step = step if "step" in there else position(key).astype(np.float64)
    else:
        step, key = np.ones(len(key)), key if there & {"seed", "episode"} else np.arange(len(key))
    order = np.lexsort((step, key))
    _refuse_gaps(key[order], step[order], [places[row] for row in order], of_steps=of_steps)
    first, many = np.unique(key, return_index=True, return_counts=True)[1:]
    ends, actions = np.cumsum(many), [did or () for did in cells["actions"]]
    if of_steps:
        did, steps = [cells["action"][row] for row in order], many.astype(np.float64)
        actions = [tuple(filter(None, did[end - n : end])) for end, n in zip(ends, many, strict=True)]
    once = np.fmax.reduceat(solved[order], ends - many)
    once[np.isnan(solved[order][ends - 1]) & (once < 1)] = np.nan
    scored, last = order[~np.isnan(score[order])], np.full(len(many), np.nan)
    last[key[scored]] = score[scored]  # of several the last one stays
    if np.isnan(once).all() and np.isin(last[~np.isnan(last)], (0, 1)).all():
        once, last = last, once
    agent, condition, task, seed, _ = (column[first] for column in coded.values())
    luck = np.where(np.array([cell is not None for cell in cells["seed"]])[first], combined(task, seed), -1)
    return Episodes(
        agents=names["agent"], conditions=names["condition"], tasks=names["task"], agent=agent, condition=condition,
        task=task, luck=luck, rank=position(combined(agent, condition, luck + 1)), solved=once, score=last,
        steps=np.where(np.isnan(steps), [len(did) or np.nan for did in actions], steps), actions=actions,
    )  # fmt: skip


def _refuse_gaps(key: Codes, step: Array, places: Sequence[tuple[Path, int]], *, of_steps: bool) -> None:
    """Refuse rows, in the order of episodes and steps, that do not follow on: loops and lengths would not be theirs."""
    same = np.r_[False, key[1:] == key[:-1]]
    due = np.where(same, np.r_[0, step[:-1]] + 1, np.fmin(step, 1))  # the first is 0 or 1
    for row in np.flatnonzero(step != due)[:1].tolist():
        (before, earlier), (path, line) = places[row - 1], places[row]
        of = f"line {earlier}" + f" of {before}" * (before != path)
        said = f"got again the episode of {of} (a column episode tells several apart), expected each once"
        if of_steps:
            after = f" after {of}" * bool(same[row])
            expected = f"step {due[row]:g} (without a column of steps rows count as they come)"
            said = f"got step {step[row]:g} of an episode{after}, expected {expected}"
        raise BadFile(path, f"line {line}: {said}")
