"""Reads a user's MJCF file (a box, or a hand) as untrusted data, and compiles it, within limits.

MuJoCo gets the text, the files that it includes, and the contents of those that it refers to under other names. So it
opens no file by itself, and nothing is read outside the folder of the model.
"""

from __future__ import annotations

import hashlib
import math
import re
import warnings
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from xml.parsers import expat

import mujoco
import numpy as np
from PIL import Image, PngImagePlugin

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import read_input
from lockprobe_robot.arm.model import TOOL_SITE
from lockprobe_robot.geom_groups import CAMERA
from lockprobe_robot.picture_file import open_picture

LARGEST = 1 << 24
"""Bytes of the model and of all files that it includes or refers to."""

_MOST_ELEMENTS = 5000
"""Elements of a model and of what it includes; MuJoCo takes minutes for many more."""

_LARGEST_MEMORY = 10**9
"""Bytes for contacts and constraints."""

_ITERATIONS = ("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations", "sdf_iterations")

_LONGEST_SIDE = 4096
"""Pixels along each side of a texture."""

_REFUSED = ("extension", "plugin", "model", "attach", "replicate", "composite", "flexcomp", "flex", "skin")
"""Tags that would run code, read other models, or make many things of few words."""

_FORMATS = {"mesh": (".stl", ".obj", ".msh"), "texture": (".png",), "hfield": (".png",)}
"""Formats by kind of asset. The suffix of a file says its format."""

_BROKEN = (ValueError, RuntimeError, TypeError, mujoco.FatalError, mujoco.UnexpectedError)


class MjcfModel:
    """A user's model with the files that it refers to, read and not compiled yet.

    Args:
        wanted: The digest that it must have; empty for any.

    Attributes:
        spec: The model for MuJoCo, with the contents of all files that it needs.
        digest: 16 hexadecimal digits that change with any of the files.

    Raises:
        BadFile: If a file is missing, too large, not MJCF, outside the folder of the model or of another format, if
            the model holds something that is refused, or if it is another model.
    """

    def __init__(self, path: Path, wanted: str = "") -> None:
        self._path, self._left, self._elements = path, LARGEST, 0
        self._folder = path.resolve().parent
        self._files: dict[str, bytes] = {}
        self._included: dict[str, bytes] = {}
        text = self._scanned(path)
        try:
            self.spec = mujoco.MjSpec.from_string(text.decode(), include=self._included)
        except _BROKEN as error:
            raise BadFile(path, str(error)) from None
        self._take_assets()
        parts = sorted((name, hashlib.sha256(content).hexdigest()) for name, content in self._files.items())
        self.digest = hashlib.sha256(repr(parts).encode()).hexdigest()[:16]
        if wanted not in ("", self.digest):
            raise BadFile(path, f"another model: its digest is {self.digest}, {wanted} was asked for")

    def compile(self) -> mujoco.MjModel:
        """Compile the model; one without a camera ``lockprobe`` gets MuJoCo's free default view.

        Raises:
            BadFile: If MuJoCo refuses it, or it would simulate or render for hours, or be drawn wrongly.
        """
        for texture in self.spec.textures:
            if max(texture.width, texture.height) > _LONGEST_SIDE:
                raise BadFile(self._path, f"texture {texture.name!r} has a side of more than {_LONGEST_SIDE} pixels")
        seen = self.spec.camera(CAMERA) is not None
        if not seen:
            self.spec.worldbody.add_camera(name=CAMERA)
        mujoco.set_mju_user_warning(lambda message: None)  # else every warning is a line in a file MUJOCO_LOG.TXT
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                model = self.spec.compile()
        except _BROKEN as error:
            raise BadFile(self._path, str(error)) from None
        limited = [
            ("timestep", model.opt.timestep, 2e-4, 0.01),
            *((what, getattr(model.opt, what), 0, 1000) for what in _ITERATIONS),
            *((what, getattr(model.vis.quality, what), 0, 200) for what in ("numslices", "numstacks", "numquads")),
            ("memory in bytes", model.narena, 0, _LARGEST_MEMORY),
            ("degrees of freedom", model.nv, 0, 200),
            ("lights", model.nlight, 0, 100),
            ("materials", model.nmat, 0, 1000),
            ("textures", model.ntex, 0, 1000),
        ]
        for what, value, least, most in limited:
            if not least <= value <= most:
                raise BadFile(self._path, f"{what} is {value:g}, expected {least:g} to {most:g}")
        eye = model.camera(CAMERA).id
        if model.cam_projection[eye] != mujoco.mjtProjection.mjPROJ_PERSPECTIVE or model.cam_sensorsize[eye].any():
            raise BadFile(self._path, f"camera {CAMERA!r} is orthographic or has a sensor size, expected fovy only")
        if not seen:
            free = mujoco.MjvCamera()
            mujoco.mjv_defaultFreeCamera(model, free)
            across, up = math.radians(free.azimuth), math.radians(free.elevation)
            ahead = np.array([math.cos(up) * math.cos(across), math.cos(up) * math.sin(across), math.sin(up)])
            right = np.array([math.sin(across), -math.cos(across), 0.0])
            axes = np.array([right, np.cross(right, ahead), -ahead]).T
            mujoco.mju_mat2Quat(model.cam_quat[eye], np.ascontiguousarray(axes).ravel())
            model.cam_pos[eye] = free.lookat - free.distance * ahead
            model.cam_fovy[eye] = model.vis.global_.fovy
        return model

    def _scanned(self, path: Path) -> bytes:
        """The content of an XML file, once its tags, and the files that it includes, were looked through."""
        name, content = self._read(path)
        parser = expat.ParserCreate("utf-8")

        def start(tag: str, attributes: Mapping[str, str]) -> None:
            self._elements += 1
            where = f"line {parser.CurrentLineNumber} of {name}"
            sides = [attributes.get(side, "0") for side in ("nrow", "ncol")]
            from_file = any(name.startswith("file") for name in attributes)
            for refused, why in (
                (self._elements == 1 and tag != "mujoco", f"<{tag}>, not an MJCF file, which begins with <mujoco>"),
                (self._elements > _MOST_ELEMENTS, f"more than {_MOST_ELEMENTS} elements"),
                (tag in _REFUSED, f"<{tag}> is refused: a model is made of bodies, geoms and included files"),
                (tag == "mesh" and "builtin" in attributes, "<mesh builtin> is refused: take a geom or a mesh file"),
                (  # MuJoCo makes its points while it reads
                    tag == "hfield" and not all(re.fullmatch(r"\s*[0-9]{1,3}\s*", side) for side in sides),
                    "a height field has whole numbers up to 999 as nrow and ncol",
                ),
                (
                    from_file and tag not in (*_FORMATS, "include"),
                    f"<{tag} file> is refused: only meshes, textures and height fields",
                ),
            ):
                if refused:
                    raise BadFile(self._path, f"{where}: {why}")
            if tag == "include":
                file = attributes.get("file", "")
                part = self._inside(file, where)
                if part.resolve() == self._path.resolve() or self._name(part) in self._files:
                    raise BadFile(self._path, f"{where}: {file!r} is included a second time")
                self._included[file] = self._scanned(part)

        def doctype(*_: object) -> None:
            raise BadFile(path, f"line {parser.CurrentLineNumber}: a document type, which is refused")

        parser.StartElementHandler, parser.StartDoctypeDeclHandler = start, doctype
        try:
            parser.Parse(content, True)
        except (expat.ExpatError, ValueError) as error:
            raise BadFile(path, f"not XML ({error})") from None
        return content

    def _take_assets(self) -> None:
        """Give the model the contents of the meshes and pictures that it refers to, under names of ours."""
        spec, assets = self.spec, dict[str, bytes]()

        def taken(kind: str, file: str, folder: str) -> str:
            path = self._inside(str(Path(folder, Path(file).name if spec.strippath else file)), kind)
            if (suffix := path.suffix.lower()) not in _FORMATS[kind]:
                raise BadFile(self._path, f"{file} is refused: a {kind} is {' or '.join(_FORMATS[kind])}")
            _, content = self._read(path)
            given = f"asset-{len(assets)}-{path.stem}{suffix}"
            if suffix == ".png":  # with its pixels alone, so that MuJoCo unpacks nothing else
                picture, plain = open_picture(path, content, longest=_LONGEST_SIDE), BytesIO()
                kept = PngImagePlugin.PngInfo()
                if "srgb" in picture.info:
                    kept.add(b"sRGB", bytes([picture.info["srgb"]]))
                Image.frombytes(picture.mode, picture.size, picture.tobytes()).save(plain, "PNG", pnginfo=kept)
                content = plain.getvalue()
            assets[given] = content
            return given

        for kind, elements, folder in (
            ("mesh", spec.meshes, spec.meshdir),
            ("texture", spec.textures, spec.texturedir),
            ("hfield", spec.hfields, spec.meshdir),
        ):
            for element in elements:
                element.content_type = ""
                if element.file:
                    element.name = element.name or Path(element.file).stem
                    element.file = taken(kind, element.file, folder)
                if kind == "texture":
                    element.cubefiles = [file and taken(kind, file, folder) for file in element.cubefiles]
        spec.meshdir = spec.texturedir = ""
        spec.assets = assets

    def _read(self, path: Path) -> tuple[str, bytes]:
        name = self._name(path)
        if name not in self._files:
            self._files[name] = read_input(path, self._left)
            self._left -= len(self._files[name])
        return name, self._files[name]

    def _inside(self, file: str, where: str) -> Path:
        try:
            path = (self._folder / file).resolve()
        except (OSError, RuntimeError, ValueError):
            raise BadFile(self._path, f"{where}: {file!r} is not the name of a file") from None
        if not path.is_relative_to(self._folder):
            raise BadFile(self._path, f"{where}: {file!r} is not in the folder of the model")
        return path

    def _name(self, path: Path) -> str:
        """A file's name as seen from the folder of the model."""
        return path.resolve().relative_to(self._folder).as_posix()


def read_hand(path: Path, digest: str) -> mujoco.MjSpec:
    """Read a user's own hand: all bodies of an MJCF file, with a site ``tool`` in one of them.

    Raises:
        BadFile: If the file cannot be read, is beyond the limits, is not the one asked for, or has no site ``tool``.
    """
    file = MjcfModel(path, digest)
    if not file.spec.worldbody.bodies or all(site.name != TOOL_SITE for site in file.spec.sites):
        raise BadFile(path, f"no site {TOOL_SITE!r} in a body, which is where the hand holds the top of a knob")
    hand = file.spec.copy()
    file.compile()
    for key in hand.keys:
        hand.delete(key)
    return hand
