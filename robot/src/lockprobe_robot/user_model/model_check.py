"""What ``lockprobe box check`` asks of a user's model: its moves, a picture, and which joints the camera sees."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.cli.box_check import ModelCheck
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, with_options
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.pictures.png import to_png
from lockprobe_robot.simulation import require_mujoco
from lockprobe_robot.twin_settings import UserModelSettings
from lockprobe_robot.user_model.mjcf_file import read_model

__all__ = ["check_own_model"]


def check_own_model(box: Lockbox, model: str) -> ModelCheck:
    """Push every joint of a model in every configuration that it reaches, with the arm too if asked, and look at it.

    Args:
        box: The rules.
        model: An MJCF file, or a plant's spec: ``twin?model=FILE&root=.``.

    Raises:
        BadFile: If the model cannot be read, lacks a joint, or does not rest in the initial configuration.
        BadValue: If the spec is that of another plant.
        Missing: If a package is missing.
    """
    require_mujoco()
    from lockprobe_robot.user_model.compiled_model import CAMERA, without_stderr
    from lockprobe_robot.user_model.rules_check import push_everything
    from lockprobe_robot.user_model.user_model import HOLD, arm_before, load_joints
    from lockprobe_robot.user_model.view_check import out_of_view

    settings = _settings(model)
    path = Path(settings.model)
    joints = load_joints(box, settings)
    pushes = tuple(push_everything(joints, box, path))
    dragged = None
    if settings.arm:
        with without_stderr():
            before_arm, drag = arm_before(box, settings)
            dragged = tuple(push_everything(before_arm, box, path, push=drag))
    joints.start(box.initial)
    with _looking(box, settings, box.names) as named, _looking(box, settings, ("",) * len(box.names)) as bare:
        picture, hidden = named(box.initial), out_of_view(box, joints, bare)
    view = (
        f"camera {CAMERA!r}" if _has_camera(settings, CAMERA) else f"MuJoCo's default view, without a camera {CAMERA!r}"
    )
    return ModelCheck(
        model=path,
        pushes=pushes,
        dragged=dragged,
        with_arm=str(_spec(model).without(["arm"]).adding({"arm": "yes"})),
        handle=HOLD,
        handles=_shown_at(picture),
        out_of_view=hidden,
        picture=to_png(picture.rgb),
        view=view,
        renderer=picture.renderer,
    )


def _shown_at(picture: Frame) -> tuple[tuple[float, float], ...]:
    """Where a picture shows the middle of each handle's travel, as shares of its width and height."""
    middle = picture.camera.project(picture.handles.mean(1))
    across, down = middle[:, 0] / picture.camera.width, middle[:, 1] / picture.camera.height
    return tuple((float(x), float(y)) for x, y in zip(across, down, strict=True))


def _has_camera(settings: UserModelSettings, name: str) -> bool:
    text = read_model(Path(settings.model), settings.folder).text
    return re.search(rf'(?m)^<camera (?=.*\bname="{name}")', text) is not None


@contextmanager
def _looking(
    box: Lockbox, settings: UserModelSettings, labels: tuple[str, ...]
) -> Iterator[Callable[[Configuration], Frame]]:
    """A function that draws the model in a configuration, with labels."""
    from lockprobe_robot.user_model.user_model import UserModel

    plant = UserModel(box, labels=labels, settings=settings, rng=np.random.default_rng(0))
    try:
        yield plant.render
    finally:
        plant.close()


def _spec(model: str) -> Spec:
    """The plant's spec of a file, or of a spec."""
    if not model.startswith("twin?"):
        return Spec("twin", options={"model": model})
    spec = Spec.parse(model, "plant")
    if "model" not in spec.options:
        raise BadValue("model", model, "an MJCF file, or 'twin?model=FILE' with options")
    return spec


def _settings(model: str) -> UserModelSettings:
    return with_options(UserModelSettings, "twin?model", _spec(model).options)
