"""The plants of this distribution, each a function of its spec. Engines are imported when a plant is made."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, in_words, settings_of, with_options
from lockprobe.plants.catalogue import FilmHook, Make, PlantSource
from lockprobe.plants.manual import TerminalOperator
from lockprobe.trial.protocols import Plant
from lockprobe_robot.twin_settings import CameraSettings, SceneSettings, TwinSettings, UserModelSettings

_FILES = ("model", "digest", "hand", "hand_digest")
"""Options that say which plant it is, and no property of it."""

_SIZES = ("width", "height")
"""Numbers that are no doses."""


def fast_twin(spec: Spec) -> PlantSource:
    """The mechanism, pushed without an arm, and a camera.

    Options: tilt, looks, friction, width, height, depth_noise. Harder pictures: discs, board, labels, handle_colours,
    clutter, view_jitter, light, colours, viewpoint.
    """
    settings = with_options(SceneSettings, "fast-twin", spec.options)

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        from lockprobe_robot.fast_twin import FastTwin

        return FastTwin(box, labels=labels, settings=settings, rng=rng)

    return replace(_pictured(spec, settings, make), lays_out=True)


def twin(spec: Spec) -> PlantSource:
    """The same with a robot arm, a hand and a force sensor.

    Options: those of fast-twin, and pose_error, force_noise, hand. A user's own model of the box: model, digest, force,
    torque, and the camera's options. The spec includes the digest of the files of others, to detect a changed one.
    """
    for file, digest in (("model", "digest"), ("hand", "hand_digest")):
        if (named := spec.options.get(file)) is not None and not spec.options.get(digest):
            from lockprobe_robot.user_model.mjcf_file import MjcfModel

            spec = spec.adding({digest: MjcfModel(Path(named)).digest})
    if "model" in spec.options:
        return _of_a_user(spec)
    settings = with_options(TwinSettings, "twin", spec.options)

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None) -> Plant:
        from lockprobe_robot.twin import Twin

        return Twin(box, labels=labels, settings=settings, rng=rng, film=film)

    return replace(_pictured(spec, settings, make), lays_out=True, has_arm=True, make_filmed=make)


def _pictured(spec: Spec, settings: CameraSettings, make: Make) -> PlantSource:
    """A simulated plant, which this machine has to be able to simulate and to draw, with a box that can be built."""

    def check(box: Lockbox) -> None:
        renderer()
        make(box, box.names, np.random.default_rng(0)).close()

    size, known = (settings.width, settings.height), settings_of(settings)
    return PlantSource(
        spec=str(spec),
        make=make,
        check=check,
        picture_size=size,
        options={name: in_words(value) for name, value in known.items() if name not in _FILES},
        doses=tuple(name for name, value in known.items() if type(value) in (int, float) and name not in _SIZES),
    )


def renderer() -> str:
    """The name, with versions, of what draws pictures here.

    Raises:
        Missing: If nothing does.
        BadValue: If ``MUJOCO_GL`` names an OpenGL platform that is not there, so that MuJoCo cannot be imported.
    """
    try:
        from lockprobe_robot.renderer import renderer_name
    except (AttributeError, ImportError, RuntimeError):
        raise BadValue("MUJOCO_GL", os.environ.get("MUJOCO_GL"), "a platform that works here; unset it") from None
    return renderer_name()


def _of_a_user(spec: Spec) -> PlantSource:
    """The plant of a user's model."""
    settings = with_options(UserModelSettings, "twin?model", spec.options)

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        from lockprobe_robot.user_model.user_model import UserModel

        return UserModel(box, labels=labels, settings=settings, rng=rng)

    def check(box: Lockbox) -> None:
        renderer()
        from lockprobe_robot.user_model.user_model import check_model

        check_model(box, settings)

    return replace(_pictured(spec, settings, make), check=check, lays_out=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class _ManualSettings:
    camera: str = ""


def manual(spec: Spec) -> PlantSource:
    """A real box whose joints a person moves; a camera tells the truth.

    Options: camera (a folder with ``handles.toml`` in which pictures are saved).
    """
    folder = with_options(_ManualSettings, "manual", spec.options).camera

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        from lockprobe_robot.hardware.sight import HANDLES_FILE, CameraSight, FolderCamera, Photographed, read_handles

        handles = read_handles(Path(folder, HANDLES_FILE), box)
        sight = CameraSight(FolderCamera(folder), handles)
        return Photographed(box, labels=labels, operator=TerminalOperator(), sight=sight)

    return PlantSource(
        spec=str(spec),
        make=make,
        check=lambda box: make(box, box.names, np.random.default_rng(0)).close(),
        photographs=True,
        lays_out=False,
        is_attended=lambda: True,
        options={},
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _RehearsalSettings:
    rung: Literal["scripted", "twin"] = "scripted"


def rig(spec: Spec) -> PlantSource:
    """The adapter of a real arm, in rehearsal.

    Options: rung (scripted, twin).
    """
    settings = with_options(_RehearsalSettings, "rig", spec.options)

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None) -> Plant:
        from lockprobe_robot.hardware.rehearsal import rehearsed_rig

        return rehearsed_rig(settings.rung, box, labels, rng, film)

    return PlantSource(
        spec=str(spec),
        make=make,
        make_filmed=None if settings.rung == "scripted" else make,
        check=lambda box: make(box, box.names, np.random.default_rng(0)).close(),
        has_arm=True,
        options={},
    )
