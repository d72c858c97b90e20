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

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.boxes.box import Joint, Lockbox, bits
from lockprobe.boxes.solve import fault_of
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.inputs import read_toml
from lockprobe.foundation.validation import plain

_NAME, _BITS = r"^[A-Za-z][A-Za-z0-9_-]{0,39}$", r"^[01]{2,8}$"
_PATTERNS = {
    _NAME: "expected a name: a letter, then at most 39 letters, digits, - and _",
    _BITS: "expected a 0 or 1 for each of 2 to 8 joints, in quotes",
}

Name = Annotated[str, Field(pattern=_NAME)]
Unit = Annotated[float, Field(ge=0, le=1)]


class _JointTable(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: Name
    kind: Literal["prismatic", "revolute"]
    place: tuple[Unit, Unit] | None = None


class _BoxTable(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: Name
    target: Name
    initial: Annotated[str, Field(pattern=_BITS)]
    joints: Annotated[list[_JointTable], Field(min_length=2, max_length=8)]
    interlock: dict[Name, Annotated[list[dict[Name, Literal[0, 1]]], Field(min_length=1, max_length=32)]] = {}


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
    box_from_data(box.as_data())  # whose names a file can hold
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


def box_from_data(data: object) -> Lockbox:
    """Build a box from parsed tables of the form above; the inverse of ``Lockbox.as_data``."""
    try:
        table = _BoxTable.model_validate(data)
        without = [joint.name for joint in table.joints if joint.place is None]
        if 0 < len(without) < len(table.joints):
            raise UserMistake(f"place: got none for {', '.join(without)}, expected one for every joint or for none")
        return Lockbox(
            name=table.name,
            joints=tuple(Joint(name=j.name, kind=j.kind, place=j.place or (0.5, 0.5)) for j in table.joints),
            interlock={
                joint: tuple({other: bool(position) for other, position in clause.items()} for clause in clauses)
                for joint, clauses in table.interlock.items()
            },
            initial=tuple(bit == "1" for bit in table.initial),
            target=table.target,
        )
    except ValidationError as error:
        first = error.errors()[0]
        said, loc = _PATTERNS.get(first.get("ctx", {}).get("pattern", ""), plain(first["msg"])), first["loc"]
        joint = data["joints"][loc[1]] if isinstance(data, dict) and loc[0] == "joints" and len(loc) > 1 else None
        if first["type"] == "extra_forbidden":
            said += f"; keys are {', '.join((_BoxTable if joint is None else _JointTable).model_fields)}"
        elif isinstance(got := first["input"], str | int | float):
            said = f"got {got!r}, {said}"
        where = f" ({joint['name']})" if isinstance(joint, dict) and "name" in joint else ""
        raise UserMistake(f"{'.'.join(map(str, loc))}{where}: {said}") from None
