"""The memory that a user's model takes, added up from its description before MuJoCo compiles it.

A few hundred bytes of MJCF can ask for gigabytes: pixels of textures, points of height fields, dimensions of sensors.
Each unit below counts everything that is allocated for it until a picture has been taken: MuJoCo's description, the
compiled model, the states of simulation and renderer, and the graphics memory. The units are measured, rounded up.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import mujoco

from lockprobe.foundation.errors import BadFile
from lockprobe_robot.user_model.assets import png_sides, triangles_and_vertices
from lockprobe_robot.user_model.mjcf_file import MjcfModel

__all__ = ["LARGEST_MEMORY", "Part", "check_memory", "check_reading", "degrees_of_freedom", "parts_of"]

LARGEST_MEMORY = 10**9
"""Bytes that a model may take in all."""

_CHANNEL = 4
"""Bytes of one channel of one pixel of a texture."""

_UNPACKED = 8
"""Bytes of a pixel of the one picture that MuJoCo is unpacking."""

_POINT = 175
"""Bytes of a point of a height field, most of them in the renderer."""

_FACE, _VERTEX = 1000, 1000
"""Bytes of a triangle and of a vertex of a mesh, with its convex hull."""

_READ = 10
"""Bytes for a byte of a mesh file."""

_SDF = 16 << 20
"""Bytes of the octree of a mesh that is a signed distance field."""

_NUMBER = 40
"""Bytes of a number of the model or of the state, which is held up to five times."""

_ELEMENT, _CLASS = 5000, 20_000
"""Bytes of an element and of a default class, which has one element of each kind."""

_CONTACT_FIELDS, _RANGE_FIELDS = 17, 14
"""Numbers of a contact, and of a pixel of a rangefinder, if a sensor reports all of them."""

_CONTACT, _BOTH_CONSTRAINTS, _STACKED, _FREEDOM, _ARENA = 640, 13, 41, 24, 2 << 20
"""Bytes of a contact; of a pair of constraints, and for it on a stack whose size is not given; of a constraint for each
degree of freedom; and of the rest of the arena."""

_CONTACTS, _CONSTRAINTS = 100, 500
"""What MuJoCo makes room for if a model does not say it."""

_ELEMENTS = (
    *(
        "bodies",
        "geoms",
        "joints",
        "sites",
        "cameras",
        "lights",
        "frames",
        "materials",
        "textures",
        "hfields",
        "meshes",
    ),
    *("pairs", "excludes", "equalities", "tendons", "actuators", "sensors", "keys", "texts", "tuples", "numerics"),
)
"""The lists of elements of a description."""

_LONGEST_SENSOR = 6
"""The most numbers of a sensor without dimensions of its own."""

_SIX_SIDED = (mujoco.mjtTexture.mjTEXTURE_CUBE, mujoco.mjtTexture.mjTEXTURE_SKYBOX)

_GEOM, _SENSOR = mujoco.mjtGeom, mujoco.mjtSensor

_DEGREES = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}
_POSITIONS = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}


class Part(NamedTuple):
    """One part of the sum: what takes it, in the plural, and its bytes."""

    what: str
    size: int


class _MeshSize(NamedTuple):
    """Triangles and vertices of a mesh, and bytes of its file."""

    triangles: int
    vertices: int
    file: int


def degrees_of_freedom(spec: mujoco.MjSpec) -> int:
    """The degrees of freedom of a parsed model."""
    return sum(_DEGREES.get(joint.type, 1) for joint in spec.joints)


def check_reading(file: MjcfModel) -> None:
    """Refuse a model whose height fields alone are too large: MuJoCo makes their points while it reads the text.

    Raises:
        BadFile: As :func:`check_memory`.
    """
    sides = re.findall(r'(?m)^<hfield (?=.*\bnrow="\s*([0-9]+))(?=.*\bncol="\s*([0-9]+))', file.text)
    _check(file, [Part("height fields", _POINT * sum(int(rows) * int(columns) for rows, columns in sides))])


def check_memory(spec: mujoco.MjSpec, file: MjcfModel) -> None:
    """Refuse a model that would take more than :data:`LARGEST_MEMORY`.

    Raises:
        BadFile: If it would; the message has the sum and the largest part.
    """
    _check(file, parts_of(spec, file))


def _check(file: MjcfModel, parts: Sequence[Part]) -> None:
    total = sum(part.size for part in parts)
    if total > LARGEST_MEMORY:
        largest = max(parts, key=lambda part: part.size)
        raise BadFile(
            file.path,
            f"it would take {_megabytes(total)} of memory, expected at most {_megabytes(LARGEST_MEMORY)}; "
            f"the largest part is {_megabytes(largest.size)} for {largest.what}",
        )


def parts_of(spec: mujoco.MjSpec, file: MjcfModel) -> tuple[Part, ...]:
    """The parts of the sum for a parsed model."""
    meshes = _mesh_sizes(spec, file)
    pictures = [content for name, content in file.assets.items() if name.endswith(".png")]
    return (
        Part("textures", sum(_texture(texture, file) for texture in spec.textures)),
        Part("a picture while it is unpacked", _UNPACKED * max(map(_pixels, pictures), default=0)),
        Part("height fields", sum(_height_field(field, file) for field in spec.hfields)),
        Part("meshes", sum(map(_mesh, meshes.values()))),
        Part("signed distance fields", _SDF * len({g.meshname for g in spec.geoms if g.type == _GEOM.mjGEOM_SDF})),
        Part("sensors", _NUMBER * sum(_sensor_numbers(sensor, spec, meshes) for sensor in spec.sensors)),
        Part("actuators", _NUMBER * sum(_recalled(max(one.actdim, 1), one.nsample) for one in spec.actuators)),
        Part("keyframes", _NUMBER * _key_numbers(spec)),
        Part("user data", _NUMBER * _user_numbers(spec)),
        Part("custom numbers", _NUMBER * sum(max(one.size, 0) for one in spec.numerics)),
        Part("stack, contacts and constraints (size)", _arena(spec)),
        Part("default classes", _CLASS * file.text.count("<default")),
        Part("elements", _ELEMENT * sum(len(getattr(spec, name)) for name in _ELEMENTS)),
    )


def _texture(texture: mujoco.MjsTexture, file: MjcfModel) -> int:
    pictures = [file.assets[name] for name in (texture.file, *texture.cubefiles) if name in file.assets]
    pixels = sum(_pixels(picture) for picture in pictures)
    if not pictures:
        sides = 6 * texture.width if texture.type in _SIX_SIDED else texture.height
        pixels = max(texture.width, 0) * max(sides, 0)
    return _CHANNEL * max(int(texture.nchannel), 1) * pixels


def _height_field(field: mujoco.MjsHField, file: MjcfModel) -> int:
    points = _pixels(file.assets[field.file]) if field.file in file.assets else max(field.nrow, 0) * max(field.ncol, 0)
    return _POINT * points


def _pixels(png: bytes) -> int:
    width, height = png_sides(png)
    return width * height


def _mesh_sizes(spec: mujoco.MjSpec, file: MjcfModel) -> dict[str, _MeshSize]:
    """The sizes of meshes by name. A file counts as often as it is used."""
    read = {
        name: _MeshSize(*triangles_and_vertices(content, name.rpartition(".")[2]), len(content))
        for name in {mesh.file for mesh in spec.meshes}
        if (content := file.assets.get(name)) is not None
    }
    return {
        mesh.name: read.get(mesh.file) or _MeshSize(len(mesh.userface) // 3, len(mesh.uservert) // 3, 0)
        for mesh in spec.meshes
    }


def _mesh(size: _MeshSize) -> int:
    return _FACE * size.triangles + _VERTEX * size.vertices + _READ * size.file


def _sensor_numbers(sensor: mujoco.MjsSensor, spec: mujoco.MjSpec, meshes: Mapping[str, _MeshSize]) -> int:
    numbers = max(sensor.dim, _LONGEST_SENSOR)
    if sensor.type == _SENSOR.mjSENS_CONTACT:
        numbers = _CONTACT_FIELDS * max(sensor.intprm[2].item(), 1)
    elif sensor.type == _SENSOR.mjSENS_RANGEFINDER and sensor.objtype == mujoco.mjtObj.mjOBJ_CAMERA:
        seen = [camera.resolution for camera in spec.cameras if camera.name == sensor.objname]
        numbers = _RANGE_FIELDS * sum(max(int(width), 1) * max(int(height), 1) for width, height in seen)
    elif sensor.type == _SENSOR.mjSENS_TACTILE:
        numbers = 3 * (meshes[sensor.objname].vertices if sensor.objname in meshes else 0)
    return _recalled(numbers, sensor.nsample)


def _recalled(numbers: int, samples: int) -> int:
    """Numbers with those of a history of this many samples, each with its time."""
    return numbers + max(samples, 0) * (numbers + 1)


def _key_numbers(spec: mujoco.MjSpec) -> int:
    positions: int = sum(_POSITIONS.get(joint.type, 1) for joint in spec.joints)
    activations: int = sum(max(int(one.actdim), 1) for one in spec.actuators)
    moved = 7 * sum(bool(body.mocap) for body in spec.bodies)
    return max(int(spec.nkey), len(spec.keys)) * (2 * positions + activations + len(spec.actuators) + moved + 1)


def _arena(spec: mujoco.MjSpec) -> int:
    """The memory for stack, contacts and constraints, which a model sets as a whole or in its parts."""
    if spec.memory >= 0:
        return int(spec.memory)
    degrees = degrees_of_freedom(spec)
    contacts, constraints, stack = int(spec.nconmax), int(spec.njmax), int(spec.nstack)
    contacts = contacts if contacts >= 0 else _CONTACTS
    constraints = constraints if constraints >= 0 else _CONSTRAINTS
    stacked = 8 * stack if stack >= 0 else _STACKED * (constraints + degrees) ** 2
    rows = _BOTH_CONSTRAINTS * constraints**2 + _FREEDOM * constraints * max(degrees, 20)
    return _ARENA + stacked + rows + _CONTACT * contacts


def _user_numbers(spec: mujoco.MjSpec) -> int:
    owners = (
        *((spec.nuser_body, spec.bodies), (spec.nuser_jnt, spec.joints), (spec.nuser_geom, spec.geoms)),
        *((spec.nuser_site, spec.sites), (spec.nuser_cam, spec.cameras), (spec.nuser_tendon, spec.tendons)),
        *((spec.nuser_actuator, spec.actuators), (spec.nuser_sensor, spec.sensors)),
    )
    return max(int(spec.nuserdata), 0) + sum(max(int(each), 0) * len(elements) for each, elements in owners)


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.0f} MB" if size < 1e9 else f"{size / 1e9:.1f} GB"
