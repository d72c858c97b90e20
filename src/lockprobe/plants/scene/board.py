"""A lockbox as a MuJoCo model: board, joints, handles, light and cameras; what is behind the board is ``hidden``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue
from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.layers import NOTHING, PANEL
from lockprobe.plants.scene.appearance import Colour, Look, look_of
from lockprobe.plants.scene.cameras import EYE, add_cameras
from lockprobe.plants.scene.fitting import BAR, LEVER_HALF_WIDTH, Fitting
from lockprobe.plants.scene.gates import Gate, gates_of
from lockprobe.plants.scene.handles import add_handle
from lockprobe.plants.scene.hidden import FIRM, FIRM_REFERENCE, add_gates, case_depth
from lockprobe.plants.scene.painting import paint_board, wood
from lockprobe.plants.scene.panel import Panel, fit_panel
from lockprobe.plants.settings import SceneSettings

__all__ = ["TIMESTEP", "Scene", "compile_scene"]

TIMESTEP = 0.002
"""Seconds. Twice as long, locked joints jam."""

_HOLD = 2.5
"""With which the over-centre spring holds a handle at an end, newtons."""

_FRICTION, _DAMPING, _MASS = 0.6, 15.0, 0.15
"""At a handle: friction in newtons, damping in newtons per metre and second, apparent mass in kilograms."""

_FACE = 0.002
_TEXTURE = mujoco.mjtTextureRole.mjTEXROLE_RGB


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """A scene that is not yet compiled, so that an arm can be added.

    Names in the model: bodies ``panel`` and ``part-0``, ``part-1``, ... in panel order; joints ``joint-0``, ...; sites
    ``knob-0``, ... in the middle of a knob's top; geoms ``knob-0``, ... (what is taken hold of) and ``board``.

    Attributes:
        spec: The model's source.
        panel: Where things are.
        gates: How joints lock each other; with ``mechanism="ideal"`` as well, where nothing in the model does it.
        box: The box.
        look: How it looks.
        camera: Name of the fixed camera that sees the board; the camera for films is ``oblique``.
        ideal: Whether joint ranges have to be switched while it runs.
    """

    spec: mujoco.MjSpec
    panel: Panel
    gates: tuple[Gate, ...]
    box: Lockbox
    look: Look
    camera: str
    ideal: bool


def compile_scene(box: Lockbox, *, labels: tuple[str, ...], settings: SceneSettings, rng: np.random.Generator) -> Scene:
    """The scene of a box.

    Args:
        box: The box.
        labels: What stands beside the joints, in panel order.
        settings: Mechanism, tilt, looks, friction, size of pictures.
        rng: For looks; as many numbers are drawn whatever they are.

    Raises:
        BadValue: If the box cannot be built: its interlock needs too many gates, or its joints have no room.
        Missing: If Pillow is not there.
    """
    if len(labels) != len(box.joints):
        raise BadValue("labels", labels, f"one for each of {len(box.joints)} joints")
    look = look_of(settings.looks, rng)
    gates = gates_of(box)
    panel = fit_panel(box, tilt=settings.tilt, depth=case_depth(gates))
    spec = _empty(settings)
    body = _add_board(spec, panel, labels, look)
    for number, fitting in enumerate(panel.fittings):
        _add_joint(body, number, fitting, look, settings.friction)
    if settings.mechanism == "contact":
        add_gates(spec, body, panel, gates)
    _add_surroundings(spec, panel, look)
    add_cameras(spec, panel, look, aspect=settings.width / settings.height)
    return Scene(
        spec=spec,
        panel=panel,
        gates=gates,
        box=box,
        look=look,
        camera=EYE,
        ideal=settings.mechanism == "ideal",
    )


def _empty(settings: SceneSettings) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = "lockbox"
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP
    # With sparse matrices, which MuJoCo 4.0.0 takes from 60 degrees of freedom on, its solver does not always converge.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.stat.extent = 1.0
    spec.stat.center = [0.35, 0, 0.3]
    spec.visual.map.znear = 0.05
    spec.visual.map.zfar = 8.0
    spec.visual.map.shadowclip = 2.5
    spec.visual.headlight.ambient = [0.32, 0.32, 0.33]
    spec.visual.headlight.diffuse = [0.22, 0.22, 0.22]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.visual.quality.shadowsize = 2048
    spec.visual.global_.offwidth = max(settings.width, 640)
    spec.visual.global_.offheight = max(settings.height, 480)
    return spec


def _material(spec: mujoco.MjSpec, name: str, picture: NDArray[np.uint8]) -> str:
    """A material that is covered by a picture once; its first row is at the top as one sees the panel."""
    rows, columns, _ = picture.shape
    texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=columns, height=rows, nchannel=3)
    texture.data = np.ascontiguousarray(picture).tobytes()
    material = spec.add_material(name=name, texrepeat=[1, 1], texuniform=False, specular=0.1, shininess=0.2)
    material.textures[_TEXTURE] = name
    return name


def _add_board(spec: mujoco.MjSpec, panel: Panel, labels: tuple[str, ...], look: Look) -> mujoco.MjsBody:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(panel.pose[:3, :3]).ravel())
    body = spec.worldbody.add_body(name="panel", pos=panel.pose[:3, 3], quat=quaternion)
    width, height = panel.size
    body.add_geom(
        name="board",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[width / 2, height / 2, _FACE / 2],
        pos=[0, 0, -_FACE / 2],
        material=_material(spec, "board", paint_board(panel, labels, look)),
        contype=PANEL,
        conaffinity=NOTHING,
    )
    dark: Colour = (0.82 * look.wood[0], 0.82 * look.wood[1], 0.82 * look.wood[2])
    body.add_geom(
        name="case",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[width / 2, height / 2, (panel.depth - _FACE) / 2],
        pos=[0, 0, -_FACE - (panel.depth - _FACE) / 2],
        material=_material(spec, "case", wood((128, 512), dark, look.grain + 1)),
        contype=PANEL,
        conaffinity=NOTHING,
    )
    return body


def _add_joint(body: mujoco.MjsBody, number: int, fitting: Fitting, look: Look, friction: float) -> None:
    """A slider or a lever, its over-centre spring, and its handle."""
    x, y = fitting.origin
    part = body.add_body(name=f"part-{number}", pos=[x, y, 0])
    slides = fitting.kind == "prismatic"
    arm = 1.0 if slides else fitting.reach
    # The spring pushes away from the middle of the travel: a negative stiffness about it.
    part.add_joint(
        name=f"joint-{number}",
        type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
        axis=[math.cos(fitting.direction), math.sin(fitting.direction), 0] if slides else [0, 0, 1],
        range=[0, fitting.travel],
        limited=True,
        stiffness=[-_HOLD * arm / (fitting.travel / 2), 0, 0],
        springref=fitting.travel / 2,
        damping=[_DAMPING * arm**2, 0, 0],
        frictionloss=_FRICTION * friction * arm,
        armature=_MASS * arm**2,
        solref_limit=FIRM_REFERENCE,
        solimp_limit=FIRM,
    )
    knob = fitting.knob(0.0) - np.array(fitting.origin)
    add_handle(part, number, knob, look)
    if slides:
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[*BAR, 0.005],
            pos=[0, 0, 0.007],
            quat=[math.cos(fitting.direction / 2), 0, 0, math.sin(fitting.direction / 2)],
            rgba=[*look.bar, 1],
            mass=0.02,
            contype=PANEL,
            conaffinity=NOTHING,
        )
        return
    middle = knob / 2
    part.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[fitting.reach / 2 + 0.006, LEVER_HALF_WIDTH, 0.005],
        pos=[middle[0], middle[1], 0.007],
        quat=[math.cos(fitting.direction / 2), 0, 0, math.sin(fitting.direction / 2)],
        rgba=[*look.bar, 1],
        mass=0.02,
        contype=PANEL,
        conaffinity=NOTHING,
    )
    for middle, radius, top, colour in ((np.zeros(2), 0.0165, 0.013, look.bar), (np.zeros(2), 0.0065, 0.016, None)):
        part.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[radius, top / 2, 0],
            pos=[middle[0], middle[1], top / 2],
            rgba=[*(colour or (0.2, 0.2, 0.2)), 1],
            mass=0.002,
            contype=NOTHING,
            conaffinity=NOTHING,
        )


def _add_surroundings(spec: mujoco.MjSpec, panel: Panel, look: Look) -> None:
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[6, 6, 0.1],
        rgba=[*look.floor, 1],
        contype=PANEL,
        conaffinity=NOTHING,
    )
    x, y, z = panel.pose[:3, 3] - panel.depth * panel.pose[:3, 2]
    foot = 0.5 * (z + 0.3 * panel.depth)
    spec.worldbody.add_geom(
        name="foot",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.05, 0.3 * panel.size[0], foot],
        pos=[x, y, foot],
        rgba=[0.25, 0.26, 0.28, 1],
        contype=PANEL,
        conaffinity=NOTHING,
    )
    across, along = look.light
    place = np.array([0.5 + across, along, 1.6])
    toward = panel.pose[:3, 3] - place
    for name, position, direction, share, shadow in (
        ("lamp", place, toward / np.linalg.norm(toward), 0.54, True),
        ("sky", np.array([0.9, -0.6, 1.8]), np.array([-0.35, 0.3, -0.9]), 0.10, False),
    ):
        spec.worldbody.add_light(
            name=name,
            pos=position,
            dir=direction,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            diffuse=[look.brightness * share] * 3,
            specular=[0.15 * look.brightness * shadow] * 3,
            castshadow=shadow,
        )
