"""Files of learners (``.npz``): parameters as 32-bit floats, and the training settings as JSON.

The same training gives the same bytes. A file may come from anywhere: no code runs from it, and its sizes are checked
before anything is read.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from shlex import quote

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from lockprobe.errors import BadFile
from lockprobe.inputs import read_input
from lockprobe.learner.network import MOST_HIDDEN, MOST_JOINTS, Network, shapes
from lockprobe.learner.training import TrainingSettings
from lockprobe.storage.atomic_file import write_file

__all__ = ["SHIPPED", "Learned", "TrainedBy", "load", "save", "shipped"]

SHIPPED = ("novice", "apprentice", "adept")
"""The learners that ship, by competence."""

_LARGEST = 2 << 20
_TRAINING = "training.json"


class TrainedBy(BaseModel):
    """The training settings of a network, as its file holds them."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    updates: int = Field(ge=1)
    joints: int = Field(ge=2, le=MOST_JOINTS)
    hidden: int = Field(ge=1, le=MOST_HIDDEN)
    seed: int
    told_lies: bool
    schedule: int = Field(ge=1)
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
    if not path.exists():
        raise BadFile(path, "does not exist; lockprobe learn --out FILE trains a learner")
    content = read_input(path, _LARGEST)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            trained = TrainedBy.model_validate(json.loads(_member(archive, _TRAINING, 4096)))
            arrays = _arrays(archive, shapes(trained.joints, trained.hidden))
    except (zipfile.BadZipFile, KeyError, ValueError, ValidationError, NotImplementedError, EOFError) as error:
        raise BadFile(path, "not the file of a learner") from error
    return Learned(network=Network(**arrays), trained=trained, sha256=sha256(content).hexdigest())


def shipped(name: str) -> Learned:
    """A shipped learner by name, one of :data:`SHIPPED`."""
    return load(Path(str(files("lockprobe.learner").joinpath(f"{name}.npz"))))


def _arrays(archive: zipfile.ZipFile, expected: Mapping[str, tuple[int, ...]]) -> dict[str, np.ndarray]:
    found = {}
    for name, shape in expected.items():
        most = 4 * int(np.prod(shape)) + 256
        array = np.lib.format.read_array(io.BytesIO(_member(archive, f"{name}.npy", most)), allow_pickle=False)
        if array.shape != shape or array.dtype != np.dtype("<f4") or not np.isfinite(array).all():
            raise ValueError(f"{name} is not {shape} finite 32-bit numbers")
        found[name] = array.astype(np.float64)
    return found


def _member(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    if archive.getinfo(name).file_size > most:
        raise ValueError(f"{name} is too large")
    return archive.read(name)
