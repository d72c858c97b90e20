"""Which column of a file is which: what a TOML file, or the name of a preset, says of it.

A line ``agent = "model_name"`` names the column of the file. ``condition = { constant = "plain" }`` gives all rows one
value, ``score = { column = "r", low = 0, high = 500 }`` says what counts as 0 and as 1. ``preset`` begins from names
that a benchmark uses, and ``control`` names the condition that the others are compared with.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
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
        scale: The scores that count as 0 and as 1.
        control: The condition that the others are compared with; empty for the first in the file.
        inspect: Whether the file is a log of Inspect.
    """

    names: dict[str, str]
    asked: set[str] = field(default_factory=set)
    constants: dict[str, str] = field(default_factory=dict)
    scale: tuple[float, float] = (0.0, 1.0)
    control: str = ""
    inspect: bool = False


def read_map(asked: str = "") -> ColumnMap:
    """The columns that a preset or a TOML file names; without one all have our names.

    Raises:
        UnknownName: If a name is neither a column nor a setting, or no preset.
        BadFile: If the file cannot be read, or a value is none of the forms above.
    """
    written = {"preset": asked} if asked in PRESETS else read_toml(Path(asked)) if asked else {}
    preset, control = (str(written.pop(name, "")) for name in ("preset", "control"))
    if preset and preset not in PRESETS:
        raise UnknownName("preset", preset, PRESETS)
    theirs = dict(pair.split("=") for pair in PRESETS.get(preset, "").split())
    found = ColumnMap({name: name for name in COLUMNS} | theirs, control=control, inspect=preset == "inspect")
    for name, value in written.items():
        if name not in COLUMNS:
            raise UnknownName(f"column, or setting of {asked},", name, (*COLUMNS, "preset", "control"))
        found.asked.add(name)
        match value:
            case str():
                found.names[name] = value
            case {"constant": str() | int() | float() as constant, **rest} if not rest:
                found.constants[name] = str(constant)
            case {"column": str() as column, "low": int() | float() as low, "high": int() | float() as high} if (
                name == "score" and low != high and isfinite(low) and isfinite(high)
            ):
                found.names[name], found.scale = column, (low, high)
            case _:
                scale = ", or { column = NAME, low = NUMBER, high = NUMBER }" * (name == "score")
                said = f"got {value!r}, expected the name of a column, {{ constant = VALUE }}{scale}"
                raise BadFile(asked, f"{name}: {said}")
    return found
