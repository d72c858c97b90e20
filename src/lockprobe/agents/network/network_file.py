"""Files of learners (``.npz``): parameters as 32-bit floats, and the training settings as JSON.

The same training gives the same bytes. A file may come from anywhere. So it is read in the one form in which it is
written: members that are neither packed nor encrypted, and arrays behind the header that their shape has. Nothing is
unpacked, no header is interpreted, and no code runs.
"""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from shlex import quote

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from lockprobe.agents.network.network import MOST_HIDDEN, MOST_JOINTS, Network, shapes
from lockprobe.agents.network.training import MOST_UPDATES, TrainingSettings
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import check_regular, read_input
from lockprobe.foundation.storage.atomic_file import write_file

__all__ = ["SHIPPED", "Learned", "TrainedBy", "load", "save", "shipped"]

SHIPPED = ("novice", "apprentice", "adept")
"""The learners that ship, by competence."""

_LARGEST = 2 << 20
_LONGEST_HEADER = 256
_ENCRYPTED = 1

_MAGIC, _FIXED = b"\x93NUMPY\x01\x00", 10
"""How an array's file begins, and the bytes before the text of its header; the last two are its length."""

_BROKEN = (
    *(zipfile.BadZipFile, KeyError, ValueError, ValidationError, NotImplementedError),
    *(EOFError, OSError, OverflowError, RecursionError, RuntimeError),
)
"""Exceptions of libraries for a damaged file."""

_TRAINING = "training.json"


class TrainedBy(BaseModel):
    """The training settings of a network, as its file holds them."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    updates: int = Field(ge=1, le=MOST_UPDATES)
    joints: int = Field(ge=2, le=MOST_JOINTS)
    hidden: int = Field(ge=1, le=MOST_HIDDEN)
    seed: int = Field(ge=-(2**63), lt=2**64)
    told_lies: bool
    schedule: int = Field(ge=1, le=MOST_UPDATES)
    box: str = Field(default="", max_length=200)

    @field_validator("box")
    @classmethod
    def _is_seen(cls, name: str) -> str:
        if not name.isprintable():
            raise ValueError("a name without control characters")
        return name

    @property
    def command(self) -> str:
        """The command that trains it again, without the file name. The name of a box is one word, whatever is in it."""
        told = " --told-lies" if self.told_lies else ""
        box = f" --box {quote(self.box)}" if self.box else f" --joints {self.joints}"
        return (
            f"lockprobe learn --updates {self.updates}{box} --hidden {self.hidden} --seed {self.seed}"
            f" --schedule {self.schedule}{told}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """A trained network with its provenance.

    Attributes:
        network: The network.
        trained: Its training settings.
        sha256: SHA-256 of its file, 64 hexadecimal digits.
    """

    network: Network
    trained: TrainedBy
    sha256: str


def save(path: Path, network: Network, settings: TrainingSettings) -> None:
    """Write a network to a file atomically.

    Raises:
        BadFile: If the file cannot be written.
    """
    trained = TrainedBy(
        updates=settings.updates,
        joints=settings.joints,
        hidden=settings.hidden,
        seed=settings.seed,
        told_lies=settings.told_lies,
        schedule=settings.schedule,
        box="" if settings.box is None else settings.box.name,
    )
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:  # numpy.savez would write the time of day
        archive.writestr(zipfile.ZipInfo(_TRAINING), trained.model_dump_json(indent=1))
        for name, array in network.arrays().items():
            numbers = io.BytesIO()
            np.lib.format.write_array(numbers, array.astype("<f4"), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), numbers.getvalue())
    write_file(path, content.getvalue())


def load(path: Path) -> Learned:
    """Read a network from a file.

    Raises:
        BadFile: If the file is missing or damaged.
    """
    check_regular(path)
    if not path.exists():
        raise BadFile(path, "does not exist; lockprobe learn --out FILE trains a learner")
    content = read_input(path, _LARGEST)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            trained = TrainedBy.model_validate(json.loads(_member(archive, _TRAINING, 4096)))
            arrays = _arrays(archive, shapes(trained.joints, trained.hidden))
    except _BROKEN as error:
        raise BadFile(path, "not the file of a learner") from error
    return Learned(network=Network(**arrays), trained=trained, sha256=sha256(content).hexdigest())


def shipped(name: str) -> Learned:
    """A shipped learner by name, one of :data:`SHIPPED`."""
    return load(Path(str(files("lockprobe.agents.network").joinpath(f"{name}.npz"))))


def _arrays(archive: zipfile.ZipFile, expected: Mapping[str, tuple[int, ...]]) -> dict[str, np.ndarray]:
    found = {}
    for name, shape in expected.items():
        size = 4 * math.prod(shape)
        content = _member(archive, f"{name}.npy", size + _LONGEST_HEADER)
        if not _is_header(content[:-size], shape):
            raise ValueError(f"{name} is not {shape} 32-bit numbers")
        array = np.frombuffer(content, "<f4", offset=len(content) - size).reshape(shape).astype(np.float64)
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds numbers that are not finite")
        found[name] = array
    return found


def _is_header(header: bytes, shape: tuple[int, ...]) -> bool:
    """Whether this is NumPy's header of an array of 32-bit floats with this shape, whatever pads it."""
    text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}"
    said = header[_FIXED:].rstrip()
    return header[:_FIXED] == _MAGIC + len(header[_FIXED:]).to_bytes(2, "little") and said == text.encode()


def _member(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    member = archive.getinfo(name)
    if member.compress_type != zipfile.ZIP_STORED or member.flag_bits & _ENCRYPTED:
        raise ValueError(f"{name} is packed or encrypted")
    if member.file_size > most:
        raise ValueError(f"{name} is too large")
    return archive.read(member)
