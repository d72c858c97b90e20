"""A lockbox as a MuJoCo model: board, joints, handles, light and cameras."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe_robot.box_model.appearance import Appearance, Colour, appearance_of
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
from lockprobe_robot.box_model.view import View, view_of
from lockprobe_robot.filming import add_film_camera
from lockprobe_robot.geom_groups import HIDDEN, NOTHING, PANEL
from lockprobe_robot.twin_settings import SceneSettings

TIMESTEP = 0.002
"""Seconds. With twice this time step, locked joints jam."""

_HOLD = 2.5
"""Force with which the over-centre spring holds a handle at either end, newtons."""

_FRICTION, _DAMPING = 0.6, 15.0
"""At a handle: friction in newtons, damping in newtons per metre and second; both, like the spring, chosen by eye."""

_FACE = 0.002
_TEXTURE = mujoco.mjtTextureRole.mjTEXROLE_RGB
_TOUCHED = {"contype": PANEL, "conaffinity": NOTHING}
_ONLY_SEEN = {"contype": NOTHING, "conaffinity": NOTHING}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LockboxScene:
    """An uncompiled scene of a lockbox, to which an arm can still be added.

    Names in the model: bodies ``panel`` and ``part-0``, ``part-1``, ... in panel order; joints ``joint-0``, ...; sites
    ``knob-0``, ... in the middle of a knob's top; geoms ``knob-0``, ... (the part that a hand touches) and ``board``;
    the plant's camera ``rgbd`` and the camera for films ``oblique``.

    Attributes:
        spec: The MuJoCo specification.
        panel: Positions of joints and labels.
        gates: How joints lock each other. With ``mechanism="ideal"`` the model has no parts for them.
        box: The box.
        appearance: How it looks.
        ideal: Whether joint ranges have to be switched while the simulation runs.
    """

    spec: mujoco.MjSpec
    panel: PanelLayout
    gates: tuple[Gate, ...]
    box: Lockbox
    appearance: Appearance
    ideal: bool


def build_scene(
    box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator
) -> LockboxScene:
    """Build the scene of a box.

    Args:
        box: The box.
        labels: Labels of the joints, in panel order.
        settings: Mechanism, tilt, friction, appearance, size of pictures.
        rng: Random stream of the appearance. The number of draws does not depend on the settings.

    Raises:
        BadValue: If the box cannot be built: its interlock needs too many gates, or its joints have no room.
        Missing: If Pillow is not installed.
    """
    if len(labels) != len(box.joints):
        raise BadValue("labels", labels, f"one for each of {len(box.joints)} joints")
    appearance = appearance_of(settings, rng)
    gates = gates_of(box)
    panel = lay_out_panel(box, tilt=settings.tilt, depth=case_depth(gates))
    spec = _empty(settings)
    body = _add_board(
        spec, panel, paint_board(panel, labels, appearance, target=box.names.index(box.target)), appearance
    )
    for number, mounted in enumerate(panel.mounted_joints):
        _add_joint(body, number, mounted, appearance, settings.friction)
    if settings.mechanism == "contact":
        add_gates(spec, body, panel, gates)
    _add_surroundings(spec, panel, appearance)
    view = view_of(panel, appearance, aspect=settings.width / settings.height)
    add_clutter(spec, body, panel, view, count=appearance.clutter, luck=appearance.luck)
    _add_cameras(spec, view)
    ideal = settings.mechanism == "ideal"
    return LockboxScene(spec=spec, panel=panel, gates=gates, box=box, appearance=appearance, ideal=ideal)


def _empty(settings: SceneSettings) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = "lockbox"
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP
    # MuJoCo 4.0.0 uses sparse matrices from 60 degrees of freedom on; with them its solver does not always converge.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.stat.extent = 1.0
    spec.stat.center = [0.35, 0, 0.3]
    spec.visual.map.znear = 0.05
    spec.visual.map.zfar = 8.0
    spec.visual.map.shadowclip = 4.0  # nearer, the shadow map has specks within sight
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.visual.quality.shadowsize = 2048
    spec.visual.global_.offwidth = max(settings.width, 640)
    spec.visual.global_.offheight = max(settings.height, 480)
    return spec


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
    body: mujoco.MjsBody, number: int, mounted: MountedJoint, appearance: Appearance, friction: float
) -> None:
    """A slider or a lever, its over-centre spring, and its handle."""
    x, y = mounted.origin
    part = body.add_body(name=f"part-{number}", pos=[x, y, 0])
    slides = mounted.kind == "prismatic"
    arm = 1.0 if slides else mounted.reach
    # The spring pushes away from the middle of the travel: a negative stiffness about it.
    part.add_joint(
        name=f"joint-{number}",
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
    add_handle(part, number, knob, appearance)
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


def _add_surroundings(spec: mujoco.MjSpec, panel: PanelLayout, appearance: Appearance) -> None:
    """A table with the board on a block, the floor of the room, and the light."""
    x, y, z = panel.pose[:3, 3] - panel.depth * panel.pose[:3, 2]
    sine, cosine = math.sin(panel.tilt), math.cos(panel.tilt)
    # The block ends within the case, and nowhere comes out of it.
    top = z + 0.4 * panel.depth * cosine
    half = min(0.4 * panel.size[1] * cosine, 0.4 * panel.depth / max(sine, 1e-3))
    for name, size, middle, colour in (
        ("ground", (0.85, 0.9, 0.02), (0.4, 0, -0.02), appearance.floor),
        ("foot", (half, 0.36 * panel.size[0], top / 2), (x, y, top / 2), (0.25, 0.26, 0.28)),
    ):
        spec.worldbody.add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=middle, rgba=[*colour, 1], **_TOUCHED
        )
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[6, 6, 0.1],
        pos=[0, 0, -0.75],
        rgba=[0.62, 0.62, 0.60, 1],
        **_TOUCHED,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.86, 0.88, 0.90],
        rgb2=[0.62, 0.64, 0.67],
        width=64,
        height=384,
    )
    across, along = appearance.light
    lamp = np.array([0.5 + across, along, appearance.lamp_height])
    spec.visual.headlight.ambient = appearance.ambient * np.array(_AMBIENT)
    spec.visual.headlight.diffuse = appearance.ambient * np.array(_HEADLIGHT)
    toward = panel.pose[:3, 3] - lamp
    for name, position, direction, share, shadow in (
        ("lamp", lamp, toward / np.linalg.norm(toward), 0.54, True),
        ("sky", np.array([0.9, -0.6, 1.8]), np.array([-0.35, 0.3, -0.9]), 0.10, False),
    ):
        spec.worldbody.add_light(
            name=name,
            pos=position,
            dir=direction,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            diffuse=[appearance.brightness * share] * 3,
            specular=[0.15 * appearance.brightness * shadow] * 3,
            castshadow=shadow,
        )


_BASE = 0.002
_DARK: Colour = (0.12, 0.12, 0.13)


def add_handle(part: mujoco.MjsBody, number: int, middle: NDArray[np.float64], appearance: Appearance) -> None:
    """Add a handle to a moving part, with a site in the middle of its top.

    Args:
        part: The moving part.
        number: Index of the joint in panel order.
        middle: Middle of the handle in the frame of the part, metres.
        appearance: Its shape and colour.
    """
    x, y = middle
    part.add_site(name=f"knob-{number}", pos=[x, y, KNOB_TOP], group=HIDDEN)
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
    if appearance.handle == "capped":
        _cylinder(part, middle, 0.010, _BASE, 0.032, _DARK)
        _cylinder(part, middle, KNOB_RADIUS, 0.032, KNOB_TOP, appearance.knob)
    elif appearance.handle == "ball":
        _cylinder(part, middle, 0.008, _BASE, KNOB_TOP - KNOB_RADIUS, _DARK)
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[KNOB_RADIUS, 0, 0],
            pos=[x, y, KNOB_TOP - KNOB_RADIUS],
            rgba=[*appearance.knob, 1],
            mass=0,
            **_ONLY_SEEN,
        )
    elif appearance.handle == "grooved":
        _cylinder(part, middle, KNOB_RADIUS, _BASE, 0.016, appearance.knob)
        _cylinder(part, middle, 0.012, 0.016, 0.026, _DARK)
        _cylinder(part, middle, KNOB_RADIUS, 0.026, KNOB_TOP, appearance.knob)
    elif appearance.handle == "square":
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[KNOB_RADIUS / math.sqrt(2), KNOB_RADIUS / math.sqrt(2), (KNOB_TOP - _BASE) / 2],
            pos=[x, y, (KNOB_TOP + _BASE) / 2],
            rgba=[*appearance.knob, 1],
            mass=0,
            **_ONLY_SEEN,
        )
    elif appearance.handle == "hollow":
        _cylinder(part, middle, KNOB_RADIUS, _BASE, KNOB_TOP - 0.001, appearance.knob)
        _cylinder(part, middle, 0.65 * KNOB_RADIUS, _BASE, KNOB_TOP, _DARK)


def _cylinder(
    part: mujoco.MjsBody,
    middle: NDArray[np.float64],
    radius: float,
    low: float,
    high: float,
    colour: Colour,
) -> None:
    part.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, (high - low) / 2, 0],
        pos=[middle[0], middle[1], (low + high) / 2],
        rgba=[*colour, 1],
        mass=0,
        **_ONLY_SEEN,
    )


EYE = "rgbd"
"""Name of the plant's camera."""


def _add_cameras(spec: mujoco.MjSpec, view: View) -> None:
    """Add the plant's camera, and the camera for films."""
    spec.worldbody.add_camera(name=EYE, pos=view.position, quat=_quaternion(view.axes), fovy=view.fovy)
    add_film_camera(spec)


def _quaternion(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
