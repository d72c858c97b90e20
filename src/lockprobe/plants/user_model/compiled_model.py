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

from lockprobe.errors import BadFile
from lockprobe.plants.user_model.mjcf_file import MjcfModel

__all__ = ["CAMERA", "compile_model", "without_stderr"]

CAMERA = "lockprobe"
"""Camera of the plant; a model without one gets MuJoCo's free default view."""

_MOST_GEOMS = 2000

_REDIRECTING = threading.Lock()

_BROKEN = (ValueError, RuntimeError, TypeError, mujoco.FatalError, mujoco.UnexpectedError)


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
    except _BROKEN as error:
        raise BadFile(file.path, file.explain(str(error))) from None
    for why in _beyond(model):
        raise BadFile(file.path, why)
    return model


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
    if len(spec.geoms) > _MOST_GEOMS:
        raise BadFile(file.path, f"{len(spec.geoms)} geoms, expected at most {_MOST_GEOMS}")
    model = spec.compile()
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, CAMERA) < 0:
        _add_camera(spec, model)
        model = spec.compile()
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
        ("memory in bytes", model.narena, 0, 1 << 30),
        ("degrees of freedom", model.nv, 1, 200),
        ("numslices", model.vis.quality.numslices, 0, 200),
        ("numstacks", model.vis.quality.numstacks, 0, 200),
        ("numquads", model.vis.quality.numquads, 0, 200),
    ):
        if not least <= value <= most:
            yield f"{what} is {value:g}, expected {least:g} to {most:g}"
    eye = model.camera(CAMERA).id
    if model.cam_projection[eye] != mujoco.mjtProjection.mjPROJ_PERSPECTIVE or model.cam_sensorsize[eye].any():
        yield f"camera {CAMERA!r} is orthographic or has a sensor size, expected one with fovy only"


def _add_camera(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Add MuJoCo's free default view as a fixed camera."""
    free = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, free)
    across, up = math.radians(free.azimuth), math.radians(free.elevation)
    ahead = np.array([math.cos(up) * math.cos(across), math.cos(up) * math.sin(across), math.sin(up)])
    right = np.array([math.sin(across), -math.cos(across), 0.0])
    axes = np.array([right, np.cross(right, ahead), -ahead]).T
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    spec.worldbody.add_camera(
        name=CAMERA, pos=free.lookat - free.distance * ahead, quat=quaternion, fovy=model.vis.global_.fovy
    )


def _ignored(message: str) -> None:
    pass
