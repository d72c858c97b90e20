"""A lockbox as a MuJoCo model: board, joints, handles, light and cameras, in the surroundings of ``scene.xml``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.box_model.appearance import Appearance, appearance_of
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
from lockprobe_robot.box_model.panel import CAMERA_DISTANCE, PanelLayout, camera_angle, lay_out_panel
from lockprobe_robot.geom_groups import CAMERA, HIDDEN, NOTHING, PANEL
from lockprobe_robot.twin_settings import SceneSettings

_TAKEN = re.compile(r"(bolt|lifter|arm|hand)-|(tool|wrench)$")
"""Names of hidden parts, which no joint of a box can have."""

_HOLD = 2.5
"""Force with which the over-centre spring holds a handle at either end, newtons."""

_FRICTION, _DAMPING = 0.6, 15.0
"""At a handle: friction in newtons, damping in newtons per metre and second; both, like the spring, chosen by eye."""

_FACE = 0.002

_MARGIN = 0.08
"""Margin around the board in pictures, as a share of their width or height."""

_ASIDE = math.radians(28)
"""Angle by which the oblique viewpoint is turned about the board's middle, towards its left side."""

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
    eye = _add_camera(spec, panel, settings, appearance.camera)
    add_clutter(body, panel, eye, count=settings.clutter, luck=appearance.luck)
    return LockboxScene(spec=spec, panel=panel, gates=gates, names=box.names)


def _add_board(
    spec: mujoco.MjSpec, panel: PanelLayout, front: NDArray[np.uint8], appearance: Appearance
) -> mujoco.MjsBody:
    """The board, with a picture on it whose first row is its upper edge, and the case behind it."""
    body = spec.worldbody.add_body(name="panel", pos=panel.pose[:3, 3], quat=_quaternion(panel.pose[:3, :3]))
    red, green, blue = (0.82 * part for part in appearance.wood)
    for name, top, thick, picture in (
        ("board", 0.0, _FACE, front),
        ("case", -_FACE, panel.depth - _FACE, wood((128, 512), (red, green, blue), appearance.grain + 1)),
    ):
        texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
        texture.height, texture.width, _ = picture.shape
        texture.data = np.ascontiguousarray(picture).tobytes()
        material = spec.add_material(name=name, texrepeat=[1, 1], texuniform=False, specular=0.1, shininess=0.2)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[panel.size[0] / 2, panel.size[1] / 2, thick / 2],
            pos=[0, 0, top - thick / 2],
            material=name,
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
    part.add_geom(
        name=f"knob-{number}",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,  # a hand that comes down beside the middle slides along its round top
        fromto=[*knob, 0, *knob, KNOB_TOP - KNOB_RADIUS],
        size=[KNOB_RADIUS, 0, 0],
        rgba=[*appearance.knob, 1],
        density=ALUMINIUM,
        **_TOUCHED,
    )
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
    pivot = ((0.0165, 0.013, appearance.bar), (PIVOT_RADIUS, 0.016, appearance.pivot))
    for radius, high, colour in () if slides else pivot:
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[radius, high / 2, 0],
            pos=[0, 0, high / 2],
            rgba=[*colour, 1],
            mass=0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )


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


def _add_camera(
    spec: mujoco.MjSpec, panel: PanelLayout, settings: SceneSettings, offset: tuple[float, float, float]
) -> NDArray[np.float64]:
    """The plant's camera: it sees the whole board with a margin, and never an arm at home. Returned is its position."""
    lean = panel.tilt - camera_angle(panel.tilt)
    axes = np.array([[0, -1, 0], [math.cos(lean), 0, math.sin(lean)], [-math.sin(lean), 0, math.cos(lean)]]).T
    if settings.viewpoint == "oblique":
        sine, cosine = math.sin(_ASIDE), math.cos(_ASIDE)
        axes = axes @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
    position = panel.pose[:3, 3] + CAMERA_DISTANCE * axes[:, 2]
    corners = np.array([[x / 2, y / 2, z] for x in (-1, 1) for y in (-1, 1) for z in (0, KNOB_TOP)]) * [*panel.size, 1]
    seen = (panel.in_world(corners) - position) @ axes
    across, up = np.abs(seen[:, :2] / seen[:, 2:]).max(0)
    half = max(up, across * settings.height / settings.width) / (1 - 2 * _MARGIN)
    eye: NDArray[np.float64] = position + np.array(offset)
    spec.worldbody.add_camera(name=CAMERA, pos=eye, quat=_quaternion(axes), fovy=2 * math.degrees(math.atan(half)))
    return eye


def _quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
