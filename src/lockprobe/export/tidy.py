"""Trials as tidy rows, one per step, for any statistics package."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import IO

from lockprobe.errors import Missing, readable
from lockprobe.record import Trial

__all__ = ["COLUMNS", "Cell", "Times", "tidy_columns", "tidy_rows", "write_csv", "write_jsonl", "write_parquet"]

COLUMNS = (
    "key",
    "agent",
    "box",
    "modality",
    "p",
    "repetition",
    "trial",
    "step",
    "joint",
    "moved",
    "told_moved",
    "claimed",
    "state",
    "target",
    "ending",
)
"""Names of the columns, in order."""

_WHOLE = ("repetition", "trial", "step", "moved", "told_moved", "target")
"""Those that hold whole numbers; ``p`` holds a fraction, and all others text."""

Cell = str | int | float

Times = Mapping[tuple[str, int], float]
"""Response times in milliseconds, by the key of a trial and the step, from 1."""

_NO_TIMES: Times = MappingProxyType({})


def tidy_rows(trials: Iterable[Trial], times: Times = _NO_TIMES) -> Iterator[dict[str, Cell]]:
    """One row per step.

    ``moved`` (the truth) and ``told_moved`` (what the report implied) are 0 or 1. ``claimed`` is what the agent
    said in *this* row's decision about its previous action: moved, blocked, or empty. ``state`` is the true
    configuration before the step, a bit string in panel order. ``target`` is 1 on the row that moved the target.
    A trial that broke before its first step has no row. In a modality with pictures ``told_moved`` is what the picture
    shows: the truth.

    Columns that come last, and only where they say something: ``panel``, the joints in the panel order of the trial,
    where trials have different panels (``--layout shuffled``); ``verdict``, what a robot took to have happened (moved,
    blocked or failed), where one played; ``rt_ms``, from when a step was shown to when its joint was chosen, in
    milliseconds of the browser's monotonic clock, where people played.

    Args:
        trials: The trials.
        times: The response times of people; a step without one has an empty cell.
    """
    trials = list(trials)
    more = tidy_columns(trials, times)[len(COLUMNS) :]
    for trial in trials:
        for step in trial.steps:
            last: dict[str, Cell] = {
                "panel": " ".join(trial.joints),
                "verdict": str(step.sensed.get("verdict", "")),
                "rt_ms": times.get((trial.key, step.step), ""),
            }
            row: dict[str, Cell] = {
                "key": trial.key,
                "agent": trial.agent,
                "box": trial.box,
                "modality": trial.modality,
                "p": trial.p,
                "repetition": trial.repetition,
                "trial": trial.trial,
                "step": step.step,
                "joint": step.joint,
                "moved": int(step.moved),
                "told_moved": int(step.told_moved),
                "claimed": step.decision.claimed or "",
                "state": step.state,
                "target": int(step.moved and step.joint == trial.target),
                "ending": trial.ending,
                **{name: last[name] for name in more},
            }
            yield {name: readable(cell) if isinstance(cell, str) else cell for name, cell in row.items()}


def _dealt_anew(trials: Sequence[Trial]) -> bool:
    return len({(trial.box, trial.joints) for trial in trials}) > len({trial.box for trial in trials})


def tidy_columns(trials: Sequence[Trial], times: Times = _NO_TIMES) -> tuple[str, ...]:
    """The columns of the tidy rows of these trials: :data:`COLUMNS`, and those that come last."""
    judged = any("verdict" in step.sensed for trial in trials for step in trial.steps)
    more = ("panel",) * _dealt_anew(trials) + ("verdict",) * judged + ("rt_ms",) * bool(times)
    return (*COLUMNS, *more)


def write_csv(trials: Iterable[Trial], file: IO[str], times: Times = _NO_TIMES) -> None:
    """Tidy rows with a header line. Read ``state`` as text: its leading zeros count."""
    trials = list(trials)
    writer = csv.DictWriter(file, tidy_columns(trials, times), lineterminator="\n")
    writer.writeheader()
    writer.writerows(tidy_rows(trials, times))


def write_jsonl(trials: Iterable[Trial], file: IO[str], times: Times = _NO_TIMES) -> None:
    """Tidy rows, one JSON object a line."""
    for row in tidy_rows(trials, times):
        file.write(json.dumps(row, ensure_ascii=False) + "\n")


def write_parquet(trials: Iterable[Trial], path: Path, times: Times = _NO_TIMES) -> None:
    """Tidy rows as a Parquet file, every column with its type: ``state`` is text, what is counted is whole.

    Raises:
        Missing: If pyarrow is not installed.
        OSError: If the file cannot be written.
    """
    try:
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        raise Missing("Parquet needs the package pyarrow", "pip install 'lockprobe[parquet]'") from None
    trials = list(trials)
    columns = tidy_columns(trials, times)
    kinds = {"p": arrow.float64(), "rt_ms": arrow.float64(), **dict.fromkeys(_WHOLE, arrow.int64())}
    schema = arrow.schema([(name, kinds.get(name, arrow.string())) for name in columns])
    rows = [row if row.get("rt_ms") != "" else {**row, "rt_ms": None} for row in tidy_rows(trials, times)]
    draft = path.with_name(f".{path.name}.draft")
    parquet.write_table(arrow.Table.from_pylist(rows, schema=schema), draft)
    draft.replace(path)
