"""A lockbox as an MJCF file with its interlock, for MuJoCo's viewer and other simulators."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.storage.atomic_file import write_files
from lockprobe.trial.pictures.png import to_png
from lockprobe.trial.plan import LABELS
from lockprobe_robot.scene.mechanism import Mechanism
from lockprobe_robot.scene.scene import EYE, build_scene
from lockprobe_robot.twin_settings import SceneSettings

_FREE = "-"
"""How the name of no joint of a box begins."""


def write_model(box: Lockbox, path: Path) -> None:
    """Write the scene of a box with the labels A, B and so on, in panel order. Raises as :func:`write_mjcf`.

    Raises:
        Missing: If MuJoCo is not installed.
    """
    write_mjcf(box, path, labels=tuple(LABELS[: len(box.joints)]))


def write_mjcf(box: Lockbox, path: Path, *, labels: tuple[str, ...]) -> None:
    """Write the scene of a box, and its textures as PNG files next to it: all files, or none.

    Joints, and the sites on their handles, have the names of the box's joints, and the camera is ``lockprobe``, as
    ``twin?model=FILE`` expects. The keyframe ``initial`` is the box's initial configuration; without it joints start
    at position 0. MJCF keeps six digits of every number.

    Args:
        box: The box.
        path: The XML file.
        labels: Labels of the joints, in panel order.

    Raises:
        BadValue: If the box cannot be built, or a joint has the name of a hidden part.
        BadFile: If a file cannot be written, or is no regular file.
    """
    scene = build_scene(box, labels=labels, settings=SceneSettings(), rng=np.random.default_rng(0))
    spec = scene.spec
    files: dict[Path, str | bytes] = {}
    with TemporaryDirectory() as compiled_in:
        for texture in spec.textures:
            if not texture.data:
                continue
            picture = np.frombuffer(bytes(texture.data), np.uint8).reshape(texture.height, texture.width, -1)
            texture.file = f"{path.stem}-{texture.name}.png"
            png = files[path.with_name(texture.file)] = to_png(picture)
            Path(compiled_in, texture.file).write_bytes(png)
            texture.data, texture.width, texture.height = b"", 0, 0
        spec.modelfiledir = compiled_in
        model = spec.compile()
        data = mujoco.MjData(model)
        Mechanism(model, data, scene).set_configuration(box.initial)
        spec.add_key(name="initial", qpos=data.qpos)
        _name_as(box, spec)
        spec.compile()
        files[path] = spec.to_xml()
    write_files(files)


def _name_as(box: Lockbox, spec: mujoco.MjSpec) -> None:
    """Give the parts of a scene the names that a user's model has."""
    joints = {f"joint-{number}": name for number, name in enumerate(box.names)}
    sites = {f"knob-{number}": name for number, name in enumerate(box.names)}
    hidden = ({joint.name for joint in spec.joints} - set(joints)) | ({site.name for site in spec.sites} - set(sites))
    if taken := hidden.intersection(box.names):
        raise BadValue("joint", min(taken), "another name: a hidden part of the model has this one")
    for equality in spec.equalities:
        equality.name1, equality.name2 = (joints.get(name, name) for name in (equality.name1, equality.name2))
    named = [(spec.joint(old), new) for old, new in joints.items()]
    named += [(spec.site(old), new) for old, new in sites.items()]
    for number, (part, _) in enumerate(named):
        part.name = f"{_FREE}{number}"  # a joint of the box may itself be called joint-0 or knob-1
    for part, name in named:
        part.name = name
    spec.camera(EYE).name = "lockprobe"
