"""Compiles a user's model in MuJoCo within limits, and adds a camera that sees it."""

from __future__ import annotations

import math
import os
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from lockprobe.foundation.errors import BadFile
from lockprobe_robot.user_model.assets import LONGEST_SIDE
from lockprobe_robot.user_model.mjcf_file import MjcfModel

CAMERA = "lockprobe"
"""Camera of the plant; a model without one gets MuJoCo's free default view."""

_MOST_GEOMS, _MOST_LIGHTS = 2000, 100

_LARGEST_MEMORY = 10**9
"""Bytes for contacts and constraints."""

_MOST_NAMED = 1000
"""Materials, and textures, that MuJoCo can draw."""

_MOST_DEGREES = 200
"""Degrees of freedom of the model and of a joint that has several."""

_REDIRECTING = threading.Lock()

BROKEN = (ValueError, RuntimeError, TypeError, mujoco.FatalError, mujoco.UnexpectedError)


def compile_model(file: MjcfModel) -> mujoco.MjModel:
    """Compile a user's model.

    Afterwards this process neither prints nor logs MuJoCo's warnings; an unstable simulation is detected from its
    state.

    Raises:
        BadFile: If MuJoCo refuses it, or it is beyond the limits.
    """
    mujoco.set_mju_user_warning(_ignored)  # else every warning is a line in a file MUJOCO_LOG.TXT
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model = _compiled(file)
    except BROKEN as error:
        raise BadFile(file.path, file.explain(str(error))) from None
    for why in _beyond(model):
        raise BadFile(file.path, why)
    eye = model.camera(CAMERA).id
    if model.cam_projection[eye] != mujoco.mjtProjection.mjPROJ_PERSPECTIVE or model.cam_sensorsize[eye].any():
        raise BadFile(file.path, f"camera {CAMERA!r} is orthographic or has a sensor size, expected one with fovy only")
    return model


def compiled_within_limits(spec: mujoco.MjSpec, file: MjcfModel) -> mujoco.MjModel:
    """Compile a part of a model, or raise BadFile if it is too large."""
    for what, number, most in (
        ("geoms", len(spec.geoms), _MOST_GEOMS),
        ("lights", len(spec.lights), _MOST_LIGHTS),
        ("joints", len(spec.joints), _MOST_DEGREES),
        ("pixels along a texture", max((max(one.width, one.height) for one in spec.textures), default=0), LONGEST_SIDE),
    ):
        if number > most:
            raise BadFile(file.path, f"{number} {what}, expected at most {most}")
    return spec.compile()


@contextmanager
def without_stderr() -> Iterator[None]:
    """Discard the standard error of C libraries: the mesh library is verbose."""
    with _REDIRECTING, open(os.devnull, "wb") as nowhere:  # noqa: PTH123 - a device
        kept = os.dup(2)
        os.dup2(nowhere.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)


def _compiled(file: MjcfModel) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(file.text, assets=dict(file.assets))
    if spec.camera(CAMERA) is not None:
        return compiled_within_limits(spec, file)
    spec.worldbody.add_camera(name=CAMERA)
    model = compiled_within_limits(spec, file)
    _place_camera(model)
    return model


def _beyond(model: mujoco.MjModel) -> Iterator[str]:
    """The limits that a model exceeds: it would simulate or render for hours, or be drawn wrongly."""
    for what, value, least, most in (
        ("timestep", model.opt.timestep, 2e-4, 0.01),
        ("iterations", model.opt.iterations, 1, 1000),
        ("ls_iterations", model.opt.ls_iterations, 1, 1000),
        ("noslip_iterations", model.opt.noslip_iterations, 0, 1000),
        ("ccd_iterations", model.opt.ccd_iterations, 1, 1000),
        ("sdf_iterations", model.opt.sdf_iterations, 0, 1000),
        ("memory in bytes", model.narena, 0, _LARGEST_MEMORY),
        ("degrees of freedom", model.nv, 1, _MOST_DEGREES),
        ("materials", model.nmat, 0, _MOST_NAMED),
        ("textures", model.ntex, 0, _MOST_NAMED),
        ("numslices", model.vis.quality.numslices, 0, 200),
        ("numstacks", model.vis.quality.numstacks, 0, 200),
        ("numquads", model.vis.quality.numquads, 0, 200),
    ):
        if not least <= value <= most:
            yield f"{what} is {value:g}, expected {least:g} to {most:g}"


def _place_camera(model: mujoco.MjModel) -> None:
    """Give the camera of a model without one MuJoCo's free default view."""
    free, eye = mujoco.MjvCamera(), model.camera(CAMERA).id
    mujoco.mjv_defaultFreeCamera(model, free)
    across, up = math.radians(free.azimuth), math.radians(free.elevation)
    ahead = np.array([math.cos(up) * math.cos(across), math.cos(up) * math.sin(across), math.sin(up)])
    right = np.array([math.sin(across), -math.cos(across), 0.0])
    axes = np.array([right, np.cross(right, ahead), -ahead]).T
    mujoco.mju_mat2Quat(model.cam_quat[eye], np.ascontiguousarray(axes).ravel())
    model.cam_pos[eye] = free.lookat - free.distance * ahead
    model.cam_fovy[eye] = model.vis.global_.fovy


def _ignored(message: str) -> None:
    pass
