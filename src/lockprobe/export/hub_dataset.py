"""Trials as a directory that ``datasets.load_dataset`` reads: Parquet, a split for each agent, and a card."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from lockprobe.errors import BadValue
from lockprobe.export.data_dictionary import column
from lockprobe.export.table_files import TableName, rows_of, write_table
from lockprobe.record import Trial
from lockprobe.storage.atomic_file import atomic_directory

__all__ = ["split_names", "write_hub_dataset"]

_TABLES: tuple[TableName, ...] = ("steps", "trials")


def write_hub_dataset(trials: Sequence[Trial], out: Path, licence: str | None = None) -> list[Path]:
    """Write both tables as Parquet and the card (``README.md``) into a new directory; return the directory.

    Raises:
        BadValue: If there is no trial.
        BadFile: If the directory exists or cannot be written.
        Missing: If pyarrow is not installed.
    """
    if not trials:
        raise BadValue("DIR", "no trials", "a study with at least one trial")
    names = split_names(sorted({trial.group for trial in trials}))
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
                for path in write_table(mine, draft / name / f"{split}.parquet", "parquet")[1:]:
                    path.unlink()
        (draft / "README.md").write_text(_card(names, columns, licence), "utf-8")
    return [out]


def split_names(agents: Iterable[str]) -> dict[str, str]:
    """For each agent a name that a split may have.

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


def _card(names: dict[str, str], columns: dict[TableName, tuple[str, ...]], licence: str | None) -> str:
    lines = ["---", "pretty_name: Lockprobe trials", *([f"license: {json.dumps(licence)}"] if licence else [])]
    lines += ["tags:", "- lockprobe", "configs:"]
    for table in _TABLES:
        lines += [f"- config_name: {table}", *(["  default: true"] if table == "steps" else []), "  data_files:"]
        for split in names.values():
            lines += [f"  - split: {split}", f"    path: {table}/{split}.parquet"]
    lines += ["---", "", "# Lockprobe trials", ""]
    lines += ["Agents try to open lockboxes. Every step holds the truth next to what the agent was told.", ""]
    lines += ["A trial whose `ending` is `error` is no failure to solve: `solved` is empty. Pictures are not included."]
    lines += ["", "| split | agent |", "|---|---|", *(f"| `{split}` | {_cell(a)} |" for a, split in names.items())]
    for table in _TABLES:
        lines += ["", f"## Columns of `{table}`", "", "| column | meaning |", "|---|---|"]
        lines += [f"| `{name}` | {_cell(column(name).meaning)} |" for name in columns[table]]
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
