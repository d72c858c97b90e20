"""Box files in TOML. The file is data: nothing in it runs, and its size is limited.

::

    name = "my-box"
    target = "door"
    initial = "000"             # one position per joint, in the order below

    [[joints]]                  # in panel order, left to right
    name = "door"
    kind = "revolute"           # or "prismatic"

    [[joints]]
    name = "bar"
    kind = "prismatic"

    [[joints]]
    name = "pin"
    kind = "prismatic"

    [interlock]                 # a joint moves if any of its clauses holds entirely
    door = [{ bar = 1 }]        # a joint without an entry is always free
    bar = [{ pin = 1, door = 0 }]

Every key is described in docs/boxes.md.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from lockprobe.boxes.box import Joint, Lockbox, bits, box_schema, data_of
from lockprobe.boxes.solve import fault_of
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.inputs import read_toml
from lockprobe.foundation.validation import plain


def read_box(path: Path) -> Lockbox:
    """Read the box in a TOML file of the form above."""
    try:
        box = box_from_data(read_toml(path))
    except UserMistake as error:
        raise error if isinstance(error, BadFile) else BadFile(path, str(error)) from None
    if fault := fault_of(box):
        raise BadFile(path, fault)
    return box


def toml_of(box: Lockbox) -> str:
    """The text of a TOML file from which :func:`read_box` reads the same box."""
    box_from_data(data_of(box))  # whose names a file can hold
    joints = (
        f'[[joints]]\nname = "{joint.name}"\nkind = "{joint.kind}"\nplace = [{joint.place[0]}, {joint.place[1]}]\n'
        for joint in box.joints
    )
    head = f'name = "{box.name}"\ntarget = "{box.target}"\ninitial = "{bits(box.initial)}"\n'
    interlock = ["[interlock]"]
    for joint, clauses in box.interlock.items():
        written = [", ".join(f"{other} = {int(position)}" for other, position in one.items()) for one in clauses]
        interlock.append(f"{joint} = [{', '.join(f'{{ {one} }}' if one else '{}' for one in written)}]")
    return "\n".join([head, *joints, "\n".join(interlock)]) + "\n"


def box_from_data(data: Any) -> Lockbox:
    """Build a box from parsed tables of the form above; the inverse of :func:`lockprobe.boxes.box.data_of`."""
    try:
        box = box_schema().validate_python(data)
    except ValidationError as error:
        first = error.errors()[0]
        named, loc = "expected a name: a letter, then at most 39 letters, digits, - and _", first["loc"]
        said = named if first["type"] == "string_pattern_mismatch" else plain(first["msg"])
        joint = data["joints"][loc[1]] if loc[0] == "joints" and len(loc) > 1 else None
        if first["type"] == "unexpected_keyword_argument":
            keys = (one.name for one in fields(Lockbox if joint is None else Joint) if one.init)
            said += f"; keys are {', '.join(keys)}"
        elif isinstance(got := first["input"], str | int | float):
            said = f"got {got!r}, {said}"
        where = f" ({joint['name']})" if isinstance(joint, dict) and "name" in joint else ""
        raise UserMistake(f"{'.'.join(map(str, loc))}{where}: {said}") from None
    without = [joint["name"] for joint in data["joints"] if "place" not in joint]
    if 0 < len(without) < len(box.joints):
        raise UserMistake(f"place: got none for {', '.join(without)}, expected one for every joint or for none")
    return box
