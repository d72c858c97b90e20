"""A lockbox with its interlock, and the arm if wanted, as a plain MuJoCo model: in memory, as a file, in a window.

Joints, and the sites on their handles, have the names of the box's joints, and the camera is ``lockprobe``, as
``twin?model=FILE`` expects. The keyframe ``initial`` is the box's initial configuration with the arm at home; without
it joints start at position 0. The arm's weight is balanced (``gravcomp``), so it rests while its motors do nothing.
"""

from __future__ import annotations

import re
from pathlib import Path
from tempfile import TemporaryDirectory

import mujoco
import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.storage.atomic_file import atomic_files
from lockprobe.trial.labels import LABELS
from lockprobe.trial.pictures.frame import to_png
from lockprobe_robot.arm.model import HOME, add_arm, add_hand
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.twin_settings import SceneSettings


def write_model(box: Lockbox, path: Path, *, arm: bool = False) -> None:
    """Write a model, and its textures as PNG files next to it: all files, or none. MJCF keeps six digits of numbers.

    Raises:
        BadValue: If the box cannot be built.
        BadFile: If a file cannot be written, or is no regular file.
    """
    spec = plain_scene(box, arm=arm)
    files: dict[Path, bytes] = {}
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
        spec.compile()
        # Two words that MuJoCo 3.3 (robosuite's) does not know; MuJoCo 4 means the same without them.
        plain = re.sub(r' colorspace="\w+"', "", spec.to_xml())
        files[path] = plain.replace('type="directional"', 'directional="true"').encode()
    with atomic_files(*files) as drafts:
        for draft, content in zip(drafts, files.values(), strict=True):
            draft.write_bytes(content)


def plain_scene(box: Lockbox, *, arm: bool) -> mujoco.MjSpec:
    """The scene of a box with the labels A, B and so on in panel order. Raises BadValue if it cannot be built."""
    labels = tuple(LABELS[: len(box.joints)])
    scene = build_scene(box, labels=labels, settings=SceneSettings(), rng=np.random.default_rng(0))
    spec = scene.spec
    if arm:
        add_hand(spec, add_arm(spec))
        for body in spec.bodies:
            if body.name.startswith(("arm-", "hand")):
                body.gravcomp = 1
    mechanism = Mechanism(scene)
    for number, angle in enumerate(HOME if arm else (), start=1):
        mechanism.data.joint(f"arm-{number}").qpos = angle
    mechanism.set_configuration(box.initial)
    spec.add_key(name="initial", qpos=mechanism.data.qpos)
    return spec
