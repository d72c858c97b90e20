"""A lockbox as an MJCF file, for MuJoCo's viewer and other simulators. The interlock is in it: nothing calls back."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadFile
from lockprobe.lockbox.box import Lockbox
from lockprobe.pictures.png import to_png
from lockprobe.plants.scene.board import Scene, compile_scene
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.settings import SceneSettings

__all__ = ["write_mjcf"]


def write_mjcf(box: Lockbox, path: Path, *, labels: tuple[str, ...], settings: SceneSettings | None = None) -> None:
    """Write the scene of a box, and its painted surfaces as PNG files beside it.

    Joints are called ``joint-0`` and so on in panel order. The keyframe ``initial`` is the box's initial configuration;
    without it joints begin at position 0. MJCF keeps six digits of every number.

    Args:
        box: The box.
        path: Of the XML file.
        labels: What stands beside the joints, in panel order.
        settings: Mechanism, tilt, friction; looks are plain.

    Raises:
        BadValue: If the box cannot be built.
        BadFile: If the file cannot be written.
    """
    settings = settings or SceneSettings()
    scene = compile_scene(box, labels=labels, settings=settings, rng=np.random.default_rng(0))
    spec = scene.spec
    try:
        for texture in spec.textures:
            if not texture.data:
                continue
            picture = np.frombuffer(bytes(texture.data), np.uint8).reshape(texture.height, texture.width, -1)
            texture.file = f"{path.stem}-{texture.name}.png"
            path.with_name(texture.file).write_bytes(to_png(picture))
            texture.data, texture.width, texture.height = b"", 0, 0
        spec.modelfiledir = str(path.parent)
        spec.add_key(name="initial", qpos=_initial(scene))
        spec.compile()
        path.write_text(spec.to_xml(), "utf-8")
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from error


def _initial(scene: Scene) -> NDArray[np.float64]:
    model = scene.spec.compile()
    data = mujoco.MjData(model)
    Mechanism(model, data, scene).set_configuration(scene.box.initial)
    found: NDArray[np.float64] = data.qpos.copy()
    return found
