"""A user's own box in TOML. The file is data: nothing in it runs, and its size is limited.

::

    name = "my-box"
    target = "door"
    initial = "000"             # one position per joint, in the order below

    [[joints]]                  # in panel order, left to right
    name = "door"
    kind = "revolute"           # or "prismatic"
    place = [0.2, 0.5]          # optional

    [[joints]]
    name = "bar"
    kind = "prismatic"

    [[joints]]
    name = "pin"
    kind = "prismatic"

    [interlock]                 # a joint moves if any of its clauses holds entirely
    door = [{ bar = 1 }]        # a joint without an entry is always free
    bar = [{ pin = 1, door = 0 }]
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.errors import BadFile, BadValue
from lockprobe.lockbox.box import Joint, Lockbox
from lockprobe.lockbox.solve import optimum

__all__ = ["MAX_BYTES", "box_from_data", "read_box", "read_toml"]

MAX_BYTES = 64 * 1024
"""A larger file is refused unread."""

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,39}$")]
Unit = Annotated[float, Field(ge=0, le=1)]


class _JointTable(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: Name
    kind: Literal["prismatic", "revolute"]
    place: tuple[Unit, Unit] = (0.5, 0.5)


class _BoxTable(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: Name
    target: Name
    initial: Annotated[str, Field(pattern=r"^[01]{2,8}$")]
    joints: Annotated[list[_JointTable], Field(min_length=2, max_length=8)]
    interlock: dict[Name, Annotated[list[dict[Name, Literal[0, 1]]], Field(min_length=1, max_length=32)]] = {}


def read_toml(path: Path) -> dict[str, object]:
    """The tables of a TOML file of at most :data:`MAX_BYTES`.

    Raises:
        BadFile: If it cannot be read, is too large or is not TOML.
    """
    if path.exists() and not path.is_file():
        raise BadFile(path, "not a file")
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise BadFile(path, f"larger than {MAX_BYTES} bytes")
        return tomllib.loads(content.decode("utf-8"))
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        raise BadFile(path, f"not TOML ({error})") from None


def read_box(path: Path) -> Lockbox:
    """The box in a TOML file of the form above.

    Raises:
        BadFile: If it is not such a file, or no sequence of attempts moves the target.
    """
    box = box_from_data(read_toml(path), path)
    if optimum(box) is None:
        raise BadFile(path, f"unsolvable: no sequence of attempts moves {box.target}")
    return box


def box_from_data(data: object, path: Path) -> Lockbox:
    """The box that these tables describe; ``Lockbox.as_data`` turned round.

    Args:
        data: Tables of the form above.
        path: Where they stood, for the message.

    Raises:
        BadFile: If they do not describe a box.
    """
    try:
        table = _BoxTable.model_validate(data)
        return Lockbox(
            name=table.name,
            joints=tuple(Joint(name=j.name, kind=j.kind, place=j.place) for j in table.joints),
            interlock={
                joint: tuple({other: bool(position) for other, position in clause.items()} for clause in clauses)
                for joint, clauses in table.interlock.items()
            },
            initial=tuple(bit == "1" for bit in table.initial),
            target=table.target,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise BadFile(path, f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    except BadValue as error:
        raise BadFile(path, str(error)) from None
