"""Reads a user's MJCF file as untrusted data, with limits.

MuJoCo gets one text without includes, and the contents of the files that the text refers to. So it opens no file by
itself, and nothing is read outside the folder of the model, or outside a root that the user names. Each tag of the text
is one line, so that an error of MuJoCo can name the line of the user's file. Document types are refused, and with them
XML entities.
"""

from __future__ import annotations

import hashlib
import html
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import read_input
from lockprobe_robot.user_model.assets import plain_png

LARGEST_XML = 1 << 20
"""Bytes of the model and of all files that it includes together."""

LARGEST_ASSETS = 1 << 24
"""Bytes of all meshes and pictures together."""

_MOST_INCLUDED = 50

_MOST_ELEMENTS = 10_000
"""Elements of the model with all that it includes; MuJoCo takes minutes to read many more."""

_REFUSED = {
    **dict.fromkeys(("extension", "plugin"), "a plugin would run code"),
    **dict.fromkeys(("model", "attach"), "include the file instead"),
    **dict.fromkeys(("replicate", "composite", "flexcomp", "flex", "skin"), "a box needs bodies and geoms only"),
}

_FORMATS = {"mesh": (".stl", ".obj", ".msh"), "texture": (".png",), "hfield": (".png",)}
"""Formats by kind of asset. The suffix of a file says its format, and ``content_type`` is dropped."""

_FOLDERS = {"mesh": "meshdir", "texture": "texturedir", "hfield": "meshdir"}


@dataclass(frozen=True, slots=True, kw_only=True)
class MjcfModel:
    """A model as text, with the contents of the files that it needs.

    Attributes:
        path: The file.
        text: The model for MuJoCo, with includes expanded, one line per tag.
        assets: Contents of meshes and pictures by their names in ``text``.
        names: Name in ``text`` -> the user's name of the file.
        sha256: SHA-256 of the file, hexadecimal.
        parts_sha256: SHA-256 of the names and contents of all files that it includes or refers to; empty without any.
        origins: For each line of ``text`` the file and the line of its origin.
    """

    path: Path
    text: str
    assets: Mapping[str, bytes]
    names: Mapping[str, str]
    sha256: str
    parts_sha256: str
    origins: tuple[tuple[str, int], ...]

    @property
    def digest(self) -> str:
        """16 hexadecimal digits that change with any of the files."""
        return hashlib.sha256(f"{self.sha256} {self.parts_sha256}".encode()).hexdigest()[:16]

    def explain(self, error: str) -> str:
        """Translate an error of MuJoCo to the lines and names of the user's files."""
        named = re.sub(r"\basset-\d+\.\w+", lambda found: self.names.get(found[0], found[0]), error)
        return re.sub(r"\bline (\d+)", lambda found: self._origin(int(found[1])), named).strip()

    def _origin(self, line: int) -> str:
        file, number = self.origins[min(max(line, 1), len(self.origins)) - 1]
        return f"line {number}" if file == self.path.name else f"line {number} of {file}"


@dataclass(frozen=True, slots=True)
class _Tag:
    """A start tag, or with ``attributes`` None an end tag, with its file and line."""

    name: str
    attributes: dict[str, str] | None
    file: str
    line: int


def read_model(path: Path, root: Path | None = None) -> MjcfModel:
    """Read a model and the files that it refers to.

    Args:
        path: The file.
        root: The folder that holds the model and all of its files; None for the folder of the model.

    Raises:
        BadFile: If a file is missing, too large, not XML, outside the root or of another format, or if the model holds
            something that is refused.
        BadValue: If the model is not in the root.
    """
    reader = _Reader(path, root)
    tags = reader.tags(path)
    elements = [tag for tag in tags if tag.attributes is not None]
    if len(elements) > _MOST_ELEMENTS:
        raise BadFile(path, f"{len(elements)} elements, expected at most {_MOST_ELEMENTS}")
    folders = reader.folders(tags)
    lines, origins = [], []
    for tag in tags:
        attributes = reader.checked(tag, folders)
        written = "".join(f' {name}="{html.escape(value)}"' for name, value in attributes.items())
        lines.append(f"</{tag.name}>" if tag.attributes is None else f"<{tag.name}{written}>")
        origins.append((tag.file, tag.line))
    parts = sorted((name, hashlib.sha256(content).hexdigest()) for name, content in reader.parts.items())
    return MjcfModel(
        path=path,
        text="\n".join(lines),
        assets=reader.assets,
        names=reader.names,
        sha256=hashlib.sha256(reader.main).hexdigest(),
        parts_sha256=hashlib.sha256(repr(parts).encode()).hexdigest() if parts else "",
        origins=tuple(origins),
    )


class _Reader:
    def __init__(self, path: Path, root: Path | None) -> None:
        self._path, self._left, self._left_for_assets = path, LARGEST_XML, LARGEST_ASSETS
        self._folder = path.resolve().parent
        self._root = self._folder if root is None else root.resolve()
        if not self._folder.is_relative_to(self._root):
            raise BadValue("root", str(root), f"a folder that holds {path} and its files")
        self.main = b""
        self.parts: dict[str, bytes] = {}
        self.assets: dict[str, bytes] = {}
        self.names: dict[str, str] = {}

    def tags(self, path: Path) -> list[_Tag]:
        """All tags of a file and its included files; the root tags of included files are dropped."""
        content, is_main = read_input(path, self._left), path == self._path
        self._left -= len(content)
        name = path.name if is_main else self._name(path)
        if is_main:
            self.main = content
        else:
            self.parts[name] = content
        found: list[_Tag] = []
        depth = 0
        parser = expat.ParserCreate()

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal depth
            depth += 1
            line = parser.CurrentLineNumber
            if depth == 1 and tag not in (("mujoco",) if is_main else ("mujoco", "mujocoinclude")):
                raise BadFile(path, f"line {line}: <{tag}>, not an MJCF file, which begins with <mujoco>")
            if tag == "include":
                found.extend(self.tags(self._included(attributes.get("file", ""), name, line)))
            elif depth > 1 or is_main:
                found.append(_Tag(tag, attributes, name, line))

        def end(tag: str) -> None:
            nonlocal depth
            if tag != "include" and (depth > 1 or is_main):
                found.append(_Tag(tag, None, name, parser.CurrentLineNumber))
            depth -= 1

        def doctype(*_: object) -> None:
            raise BadFile(path, f"line {parser.CurrentLineNumber}: a document type, which is refused")

        parser.StartElementHandler, parser.EndElementHandler = start, end
        parser.StartDoctypeDeclHandler = doctype
        try:
            parser.Parse(content, True)
        except (expat.ExpatError, ValueError, LookupError) as error:
            raise BadFile(path, f"not XML ({error})") from None
        return found

    def folders(self, tags: list[_Tag]) -> dict[str, str]:
        """Directories by kind of asset, from the ``compiler`` tags; the key ``strip`` exists with ``strippath``."""
        said: dict[str, str] = {}
        for tag in tags:
            if tag.name == "compiler" and tag.attributes is not None:
                said.update(tag.attributes)
        found = {kind: said.get(folder, said.get("assetdir", "")) for kind, folder in _FOLDERS.items()}
        return {**found, "strip": "yes"} if said.get("strippath") == "true" else found

    def checked(self, tag: _Tag, folders: Mapping[str, str]) -> dict[str, str]:
        """The attributes of a tag for MuJoCo: files by new names, without folders."""
        if tag.attributes is None:
            return {}
        if tag.name in _REFUSED:
            raise self._refusal(tag, f"<{tag.name}> is refused: {_REFUSED[tag.name]}")
        attributes = dict(tag.attributes)
        if tag.name == "mesh" and "builtin" in attributes:
            raise self._refusal(tag, "<mesh builtin> is refused: take a geom or a mesh file")
        if tag.name == "compiler":
            for folder in ("assetdir", "meshdir", "texturedir", "strippath"):
                attributes.pop(folder, None)
        attributes.pop("content_type", None)
        self._check_points(tag)
        for name in [name for name in attributes if name.startswith("file")]:
            if tag.name not in _FORMATS:
                raise self._refusal(tag, f"<{tag.name} {name}> is refused: only meshes, textures and height fields")
            said = Path(attributes[name]).name if "strip" in folders else attributes[name]
            if name == "file":
                attributes.setdefault("name", Path(said).stem)
            attributes[name] = self._asset(tag, Path(folders[tag.name], said))
        return attributes

    def _check_points(self, tag: _Tag) -> None:
        """Refuse large height fields, whose points MuJoCo makes while it reads the text."""
        for side in ("nrow", "ncol"):
            said = (tag.attributes or {}).get(side, "0")
            if tag.name == "hfield" and not re.fullmatch(r"\s*[0-9]{1,3}\s*", said):
                raise self._refusal(tag, f"{side} is {said[:40]!r}, expected a whole number up to 999")

    def _asset(self, tag: _Tag, relative: Path) -> str:
        path = self._inside(str(relative), tag.file, tag.line)
        if (suffix := path.suffix.lower()) not in _FORMATS[tag.name]:
            raise self._refusal(tag, f"{relative} is refused: a {tag.name} is {' or '.join(_FORMATS[tag.name])}")
        name = self._name(path)
        if name not in self.parts:
            content = self.parts[name] = read_input(path, self._left_for_assets)
            self._left_for_assets -= len(content)
        given = f"asset-{list(self.parts).index(name)}{suffix}"
        if given not in self.assets:
            self.assets[given] = plain_png(self.parts[name], path) if suffix == ".png" else self.parts[name]
            self.names[given] = name
        return given

    def _included(self, file: str, where: str, line: int) -> Path:
        path = self._inside(file, where, line)
        if len(self.parts) >= _MOST_INCLUDED:
            raise BadFile(self._path, f"line {line} of {where}: more than {_MOST_INCLUDED} files are included")
        if path == self._path.resolve() or self._name(path) in self.parts:
            raise BadFile(self._path, f"line {line} of {where}: {file!r} is included a second time")
        return path

    def _inside(self, file: str, where: str, line: int) -> Path:
        try:
            path = (self._folder / file).resolve()
        except (OSError, RuntimeError, ValueError):
            raise BadFile(self._path, f"line {line} of {where}: {file!r} is not the name of a file") from None
        if not path.is_relative_to(self._root):
            folder = "the folder of the model" if self._root == self._folder else str(self._root)
            raise BadFile(self._path, f"line {line} of {where}: {file!r} is not in {folder}{self._way_out(path)}")
        return path

    def _way_out(self, path: Path) -> str:
        """How a user allows a file outside the root, for a message; nobody allows all files of the machine."""
        shared = Path(os.path.commonpath([self._folder, path]))
        return "" if shared == shared.parent else f"; add &root={shared} to the plant to read files of that folder"

    def _name(self, path: Path) -> str:
        """A file's name as seen from the folder of the model, the same for every root."""
        return Path(os.path.relpath(path, self._folder)).as_posix()

    def _refusal(self, tag: _Tag, why: str) -> BadFile:
        where = "" if tag.file == self._path.name else f" of {tag.file}"
        return BadFile(self._path, f"line {tag.line}{where}: {why}")
