"""Which column of a file is which: what a TOML file, or the name of a preset, says of it.

A line ``agent = "model_name"`` names the column of the file, ``condition = { constant = "plain" }`` gives all rows one
value, and ``preset`` begins from names that a benchmark uses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.inputs import read_toml

TEXTS = ("agent", "condition", "task", "seed", "episode")
"""Columns that say which episode a row is of, or is part of."""

COLUMNS = (*TEXTS, "step", "action", "told", "told_falsely", "solved", "score", "steps", "actions")
"""All that a file may have, under these names or others."""

PRESETS = {
    "inspect": "",
    "balrog": "agent=model_id condition=agent steps=num_steps score=progression step=Step action=Action",
    "gymnasium": "score=r steps=l",
}
"""Names of columns that are not ours, in tables like BALROG's and by ``RecordEpisodeStatistics``; a log of Inspect is
read into ours. A file may lack some."""


@dataclass
class ColumnMap:
    """Where the values of our columns come from.

    Attributes:
        names: Our column -> that of the file.
        asked: Those that somebody named, so that they have to be there.
        constants: Our column -> what every row has.
        inspect: Whether the file is a log of Inspect.
    """

    names: dict[str, str]
    asked: set[str] = field(default_factory=set)
    constants: dict[str, str] = field(default_factory=dict)
    inspect: bool = False


def read_map(asked: str = "") -> ColumnMap:
    """The columns that a preset or a TOML file names; without one all have our names.

    Raises:
        UnknownName: If a name is no column, or no preset.
        BadFile: If the file cannot be read, or a value is none of the forms above.
    """
    written = {"preset": asked} if asked in PRESETS else read_toml(Path(asked)) if asked else {}
    preset = str(written.pop("preset", ""))
    if preset and preset not in PRESETS:
        raise UnknownName("preset", preset, PRESETS)
    theirs = dict(pair.split("=") for pair in PRESETS.get(preset, "").split())
    found = ColumnMap({name: name for name in COLUMNS} | theirs, inspect=preset == "inspect")
    for name, value in written.items():
        if name not in COLUMNS:
            raise UnknownName(f"column, or setting of {asked},", name, (*COLUMNS, "preset"))
        match value:
            case str():
                found.names[name] = value
                found.asked.add(name)
            case {"constant": str() | int() | float() as constant}:
                found.constants[name] = str(constant)
            case _:
                raise BadFile(asked, f"{name}: got {value!r}, expected the name of a column, or {{ constant = VALUE }}")
    return found
