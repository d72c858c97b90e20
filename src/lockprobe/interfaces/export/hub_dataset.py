"""Writes trials as a directory for ``datasets.load_dataset``: Parquet, a split for each agent, and a card."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import markdown_table
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import atomic_directory
from lockprobe.interfaces.export.data_dictionary import column
from lockprobe.interfaces.export.table_files import TableName, rows_of, write_table
from lockprobe.trial.record import Trial

__all__ = ["split_names", "write_hub_dataset"]

_TABLES: tuple[TableName, ...] = ("steps", "trials")


_LICENCE = re.compile(r"[a-z0-9][a-z0-9.\-]{0,60}")


def write_hub_dataset(
    trials: Sequence[Trial], out: Path, album: Path | None = None, licence: str | None = None
) -> list[Path]:
    """Write both tables as Parquet and the card (``README.md``) into a new directory; return the directory.

    Args:
        trials: The trials.
        out: The directory, which is new.
        album: The directory of the pictures that records name; without it they are left out. Pictures after a step are
            in the row of the step, those before the first step in the row of the trial.
        licence: The name of a licence as the hub writes it, for example ``cc-by-4.0``.

    Raises:
        BadValue: If there is no trial, or the licence is no such name.
        BadFile: If the directory exists or cannot be written.
        Missing: If pyarrow is not installed.
    """
    if not trials:
        raise BadValue("DIR", "no trials", "a study with at least one trial")
    if licence is not None and not _LICENCE.fullmatch(licence):
        raise BadValue("--licence", licence, "a licence as the hub names it, for example cc-by-4.0 or mit")
    names = split_names(sorted({trial.group for trial in trials}))
    pictures = None if album is None else _Pictures(trials, album)
    with atomic_directory(out) as draft:
        columns = {}
        for name in _TABLES:
            table = rows_of(name, trials)
            columns[name] = table.columns
            rows = list(table.rows)
            (draft / name).mkdir()
            for agent, split in names.items():
                keys = {trial.key for trial in trials if trial.group == agent}
                mine = replace(table, rows=[row for row in rows if row["key"] in keys])
                file, described = write_table(mine, draft / name / f"{split}.parquet", "parquet")
                described.unlink()
                if pictures is not None and pictures.kinds:
                    pictures.put(file, name)
        held = "The tables contain the pictures." if pictures and pictures.kinds else "There are no pictures."
        (draft / "README.md").write_text(_card(names, columns, licence, held), "utf-8")
    return [out]


class _Pictures:
    """The pictures of trials, as columns of tables that ``datasets`` reads as images."""

    def __init__(self, trials: Sequence[Trial], album: Path) -> None:
        self._album = album
        self._after = {(trial.key, step.step): step.pictures for trial in trials for step in trial.steps}
        self._before = {trial.key: trial.opening_pictures for trial in trials}
        self.kinds = sorted({kind for one in (*self._after.values(), *self._before.values()) for kind in one})

    def put(self, file: Path, table: TableName) -> None:
        """Add a column for each kind of picture to a Parquet file, next to the names of its images.

        Raises:
            BadFile: If a picture cannot be read.
        """
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
        made = parquet.read_table(file)
        keys = made.column("key").to_pylist()
        if table == "steps":
            names = [self._after[at] for at in zip(keys, made.column("step").to_pylist(), strict=True)]
        else:
            names = [self._before[key] for key in keys]
        form, features = arrow.struct([("bytes", arrow.binary()), ("path", arrow.string())]), _features(made.schema)
        for kind in self.kinds:
            column_name = f"picture_{kind}" if table == "steps" else f"opening_{kind}"
            made = made.append_column(column_name, arrow.array([self._read(one.get(kind)) for one in names], form))
            features[column_name] = {"_type": "Image"}
        about = json.dumps({"info": {"features": features}})
        parquet.write_table(made.replace_schema_metadata({"huggingface": about}), file)

    def _read(self, name: str | None) -> dict[str, bytes | str] | None:
        if name is None:
            return None
        return {"bytes": read_input(self._album / name), "path": name}


def _features(schema: Any) -> dict[str, dict[str, str]]:
    """The columns of a table with their types in ``datasets``."""
    names = {"int64": "int64", "double": "float64", "string": "string"}
    return {field.name: {"dtype": names[str(field.type)], "_type": "Value"} for field in schema}


def split_names(agents: Iterable[str]) -> dict[str, str]:
    """A valid name of a split for each agent.

    >>> split_names(["human-inspired", "llm:openai/gpt-4o"])
    {'human-inspired': 'human_inspired', 'llm:openai/gpt-4o': 'llm_openai_gpt_4o'}
    """
    names: dict[str, str] = {}
    for agent in agents:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", agent).strip("_")[:60] or "agent"
        name, number = plain, 2
        while name in names.values():
            name, number = f"{plain}_{number}", number + 1
        names[agent] = name
    return names


def _card(names: dict[str, str], columns: dict[TableName, tuple[str, ...]], licence: str | None, pictures: str) -> str:
    lines = ["---", "pretty_name: Lockprobe trials", *([f"license: {json.dumps(licence)}"] if licence else [])]
    lines += ["tags:", "- lockprobe", "configs:"]
    for table in _TABLES:
        lines += [f"- config_name: {table}", *(["  default: true"] if table == "steps" else []), "  data_files:"]
        for split in names.values():
            lines += [f"  - split: {split}", f"    path: {table}/{split}.parquet"]
    lines += ["---", "", "# Lockprobe trials", ""]
    lines += ["Agents try to open lockboxes. Every step holds the truth and the report to the agent.", ""]
    lines += [f"A trial whose `ending` is `error` is not a failure to solve: `solved` is empty. {pictures}"]
    lines += ["", markdown_table(("split", "agent"), *((f"`{split}`", _cell(agent)) for agent, split in names.items()))]
    for table in _TABLES:
        meanings = ((f"`{name}`", _cell(column(name).meaning)) for name in columns[table])
        lines += ["", f"## Columns of `{table}`", "", markdown_table(("column", "meaning"), *meanings)]
    lines += [
        "",
        "## Citation",
        "",
        "Zenkri and Brock, *Probing Embodied LLMs: When Higher Observation Fidelity Hurts ",
    ]
    lines[-1] += "Problem Solving*. The trials were played with Lockprobe."
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    return re.sub(r"[|<>`\r\n]", " ", text)
