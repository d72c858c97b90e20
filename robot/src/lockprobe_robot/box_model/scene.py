"""A lockbox as a MuJoCo model: board, joints, handles, light and cameras, in the surroundings of ``scene.xml``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.box_model.appearance import Appearance, Colour, HandleShape, appearance_of
from lockprobe_robot.box_model.board_texture import paint_board, wood
from lockprobe_robot.box_model.bolts import FIRM, FIRM_REFERENCE, add_gates, case_depth
from lockprobe_robot.box_model.clutter import add_clutter
from lockprobe_robot.box_model.gates import Gate, gates_of
from lockprobe_robot.box_model.mounted_joint import (
    ALUMINIUM,
    BAR,
    KNOB_RADIUS,
    KNOB_TOP,
    LEVER_HALF_WIDTH,
    PIVOT_RADIUS,
    MountedJoint,
)
from lockprobe_robot.box_model.panel import PanelLayout, lay_out_panel
from lockprobe_robot.box_model.view import view_of
from lockprobe_robot.geom_groups import CAMERA, HIDDEN, NOTHING, PANEL
from lockprobe_robot.twin_settings import SceneSettings

_TAKEN = re.compile(r"(bolt|lifter|arm|hand)-|(tool|wrench)$")
"""Names of hidden parts, which no joint of a box can have."""

_HOLD = 2.5
"""Force with which the over-centre spring holds a handle at either end, newtons."""

_FRICTION, _DAMPING = 0.6, 15.0
"""At a handle: friction in newtons, damping in newtons per metre and second; both, like the spring, chosen by eye."""

_FACE = 0.002
_TEXTURE = mujoco.mjtTextureRole.mjTEXROLE_RGB
_TOUCHED = {"contype": PANEL, "conaffinity": NOTHING}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LockboxScene:
    """An uncompiled scene of a lockbox, to which an arm can still be added.

    Names in the model: bodies ``panel`` and ``part-0``, ``part-1``, ... in panel order; joints, and sites in the middle
    of a knob's top, as the joints of the box; geoms ``knob-0``, ... (the part that a hand touches) and ``board``; the
    plant's camera ``lockprobe`` and the camera for films ``oblique``.

    Attributes:
        spec: The MuJoCo specification.
        panel: Positions of joints and labels.
        gates: How joints lock each other.
        names: The joints in panel order.
    """

    spec: mujoco.MjSpec
    panel: PanelLayout
    gates: tuple[Gate, ...]
    names: tuple[str, ...]


def build_scene(
    box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
) -> LockboxScene:
    """Build the scene of a box with the labels of its joints; its appearance draws from ``rng``.

    Raises:
        BadValue: If the box cannot be built: its interlock needs too many gates, its joints have no room, or one has
            the name of a hidden part.
    """
    if taken := [name for name in box.names if _TAKEN.match(name)]:
        raise BadValue("joint", taken[0], "another name: a hidden part of the model has this one")
    appearance = appearance_of(settings, rng)
    gates = gates_of(box)
    panel = lay_out_panel(box, tilt=settings.tilt, depth=case_depth(gates))
    spec = mujoco.MjSpec.from_file(str(Path(__file__).with_name("scene.xml")))
    front = paint_board(panel, labels, appearance, settings, target=box.names.index(box.target))
    body = _add_board(spec, panel, front, appearance)
    for number, (name, mounted) in enumerate(zip(box.names, panel.mounted_joints, strict=True)):
        _add_joint(body, number, name, mounted, appearance, settings.friction)
    add_gates(spec, body, panel, gates, box.names)
    _light(spec, panel, appearance)
    view = view_of(panel, settings.viewpoint, appearance.camera, aspect=settings.width / settings.height)
    add_clutter(spec, body, panel, view, count=settings.clutter, luck=appearance.luck)
    spec.worldbody.add_camera(name=CAMERA, pos=view.position, quat=_quaternion(view.axes), fovy=view.fovy)
    return LockboxScene(spec=spec, panel=panel, gates=gates, names=box.names)


def _material(spec: mujoco.MjSpec, name: str, picture: NDArray[np.uint8]) -> str:
    """A material with a picture on it. The picture's first row is the upper edge of the panel."""
    rows, columns, _ = picture.shape
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=columns, height=rows, nchannel=3)
    texture.data = np.ascontiguousarray(picture).tobytes()
    material = spec.add_material(name=name, texrepeat=[1, 1], texuniform=False, specular=0.1, shininess=0.2)
    material.textures[_TEXTURE] = name
    return name


def _add_board(
    spec: mujoco.MjSpec, panel: PanelLayout, front: NDArray[np.uint8], appearance: Appearance
) -> mujoco.MjsBody:
    body = spec.worldbody.add_body(name="panel", pos=panel.pose[:3, 3], quat=_quaternion(panel.pose[:3, :3]))
    width, height = panel.size
    dark: Colour = (0.82 * appearance.wood[0], 0.82 * appearance.wood[1], 0.82 * appearance.wood[2])
    for name, top, thick, picture in (
        ("board", 0.0, _FACE, front),
        ("case", -_FACE, panel.depth - _FACE, wood((128, 512), dark, appearance.grain + 1)),
    ):
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[width / 2, height / 2, thick / 2],
            pos=[0, 0, top - thick / 2],
            material=_material(spec, name, picture),
            **_TOUCHED,
        )
    return body


def _add_joint(
    body: mujoco.MjsBody, number: int, name: str, mounted: MountedJoint, appearance: Appearance, friction: float
) -> None:
    """A slider or a lever, its over-centre spring, and its handle."""
    x, y = mounted.origin
    part = body.add_body(name=f"part-{number}", pos=[x, y, 0])
    slides = mounted.kind == "prismatic"
    arm = 1.0 if slides else mounted.reach
    # The spring pushes away from the middle of the travel: a negative stiffness about it.
    part.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
        axis=[math.cos(mounted.direction), math.sin(mounted.direction), 0] if slides else [0, 0, 1],
        range=[0, mounted.travel],
        limited=True,
        stiffness=[-_HOLD * arm / (mounted.travel / 2), 0, 0],
        springref=mounted.travel / 2,
        damping=[_DAMPING * arm**2, 0, 0],
        frictionloss=_FRICTION * friction * arm,
        solref_limit=FIRM_REFERENCE,
        solimp_limit=FIRM,
    )
    knob = mounted.knob(0.0) - np.array(mounted.origin)
    part.add_site(name=name, pos=[*knob, KNOB_TOP], group=HIDDEN)
    _add_handle(part, number, knob, appearance)
    half = BAR if slides else (mounted.reach / 2 + 0.006, LEVER_HALF_WIDTH)
    part.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[*half, 0.005],
        pos=[*(knob / 2), 0.007],
        quat=[math.cos(mounted.direction / 2), 0, 0, math.sin(mounted.direction / 2)],
        rgba=[*appearance.bar, 1],
        density=ALUMINIUM,
        **_TOUCHED,
    )
    if not slides:
        _cylinder(part, np.zeros(2), 0.0165, 0.0, 0.013, appearance.bar)
        _cylinder(part, np.zeros(2), PIVOT_RADIUS, 0.0, 0.016, appearance.pivot)


_AMBIENT, _HEADLIGHT = (0.32, 0.32, 0.33), (0.22, 0.22, 0.22)
"""Light from everywhere, and light from the camera."""

_LAMP, _SKY, _SHINE = 0.54, 0.10, 0.15
"""Brightness of the lamp and of the light of the sky; of the lamp's reflections."""


def _light(spec: mujoco.MjSpec, panel: PanelLayout, appearance: Appearance) -> None:
    """Fit the block under the board, and set the light."""
    x, y, z = panel.pose[:3, 3] - panel.depth * panel.pose[:3, 2]
    sine, cosine = math.sin(panel.tilt), math.cos(panel.tilt)
    # The block ends within the case, and nowhere comes out of it.
    top = z + 0.4 * panel.depth * cosine
    half = min(0.4 * panel.size[1] * cosine, 0.4 * panel.depth / max(sine, 1e-3))
    spec.geom("foot").size, spec.geom("foot").pos = (half, 0.36 * panel.size[0], top / 2), (x, y, top / 2)
    spec.geom("ground").rgba = [*appearance.floor, 1]
    across, along = appearance.light
    lamp, sky, bright = spec.light("lamp"), spec.light("sky"), appearance.brightness
    lamp.pos = np.array([0.5 + across, along, appearance.lamp_height])
    toward = panel.pose[:3, 3] - lamp.pos
    lamp.dir = toward / np.linalg.norm(toward)
    lamp.diffuse, sky.diffuse, lamp.specular = [bright * _LAMP] * 3, [bright * _SKY] * 3, [bright * _SHINE] * 3
    spec.visual.headlight.ambient = appearance.ambient * np.array(_AMBIENT)
    spec.visual.headlight.diffuse = appearance.ambient * np.array(_HEADLIGHT)


_BASE = 0.002
_DARK: Colour = (0.12, 0.12, 0.13)

_CYLINDERS: dict[HandleShape, tuple[tuple[float, float, float, Colour | None], ...]] = {
    "capped": ((0.010, _BASE, 0.032, _DARK), (KNOB_RADIUS, 0.032, KNOB_TOP, None)),
    "ball": ((0.008, _BASE, KNOB_TOP - KNOB_RADIUS, _DARK),),
    "grooved": (
        (KNOB_RADIUS, _BASE, 0.016, None),
        (0.012, 0.016, 0.026, _DARK),
        (KNOB_RADIUS, 0.026, KNOB_TOP, None),
    ),
    "hollow": ((KNOB_RADIUS, _BASE, KNOB_TOP - 0.001, None), (0.65 * KNOB_RADIUS, _BASE, KNOB_TOP, _DARK)),
}
"""Cylinders of handles of a shape: radius, height of both ends, colour or that of the knob."""


def _add_handle(part: mujoco.MjsBody, number: int, middle: NDArray[np.float64], appearance: Appearance) -> None:
    """Add what a hand can touch and what is seen of a handle, whose middle is in the frame of the part, metres."""
    x, y = middle
    seen = appearance.handle == "round"
    part.add_geom(
        name=f"knob-{number}",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,  # a hand that comes down beside the middle slides along its round top
        fromto=[x, y, 0, x, y, KNOB_TOP - KNOB_RADIUS],
        size=[KNOB_RADIUS, 0, 0],
        rgba=[*appearance.knob, 1],
        density=ALUMINIUM,
        group=0 if seen else HIDDEN,
        **_TOUCHED,
    )
    for radius, low, high, colour in _CYLINDERS.get(appearance.handle, ()):
        _cylinder(part, middle, radius, low, high, colour or appearance.knob)
    if appearance.handle == "ball":
        _add_seen(
            part, mujoco.mjtGeom.mjGEOM_SPHERE, [KNOB_RADIUS, 0, 0], [x, y, KNOB_TOP - KNOB_RADIUS], appearance.knob
        )
    elif appearance.handle == "square":
        side = KNOB_RADIUS / math.sqrt(2)
        size, at = [side, side, (KNOB_TOP - _BASE) / 2], [x, y, (KNOB_TOP + _BASE) / 2]
        _add_seen(part, mujoco.mjtGeom.mjGEOM_BOX, size, at, appearance.knob)


def _cylinder(
    part: mujoco.MjsBody,
    middle: NDArray[np.float64],
    radius: float,
    low: float,
    high: float,
    colour: Colour,
) -> None:
    size, at = [radius, (high - low) / 2, 0], [middle[0], middle[1], (low + high) / 2]
    _add_seen(part, mujoco.mjtGeom.mjGEOM_CYLINDER, size, at, colour)


def _add_seen(
    part: mujoco.MjsBody, shape: mujoco.mjtGeom, size: Sequence[float], at: Sequence[float], colour: Colour
) -> None:
    """Add a geom that is only looked at."""
    part.add_geom(type=shape, size=size, pos=at, rgba=[*colour, 1], mass=0, contype=NOTHING, conaffinity=NOTHING)


def _quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
