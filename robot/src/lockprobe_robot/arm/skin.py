"""The arm's visible shape from MuJoCo Menagerie, if it is on this machine. It changes no physics.

Nothing is downloaded. The meshes come from a checkout that ``MENAGERIE_ROOT`` names, or from the cache of the package
``mujoco-menagerie`` (in ``MENAGERIE_CACHE_DIR`` or its default folder).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

import mujoco

from lockprobe_robot.geom_groups import HIDDEN, NOTHING

__all__ = ["find_skin", "wear_skin"]

_ROBOT = "franka_emika_panda"


def find_skin(environment: Mapping[str, str] = os.environ) -> Path | None:
    """The Menagerie's description of the Panda on this machine, or None if it has none.

    Args:
        environment: The environment variables.
    """
    if root := environment.get("MENAGERIE_ROOT"):
        folders = [Path(root) / _ROBOT]
    else:
        stored = Path(environment.get("MENAGERIE_CACHE_DIR") or _stored(environment)) / "models"
        folders = [path.parent for path in sorted(stored.glob(f"{_ROBOT}-*/.complete"))]
    return next((path for folder in folders if (path := folder / "panda.xml").is_file()), None)


def _stored(environment: Mapping[str, str]) -> Path:
    """The package's default cache folder."""
    home = Path(environment.get("HOME") or Path.home())
    if sys.platform == "win32":
        return Path(environment.get("LOCALAPPDATA") or home / "AppData/Local") / "mujoco_menagerie" / "cache"
    if sys.platform == "darwin":
        return home / "Library/Caches/mujoco_menagerie"
    return Path(environment.get("XDG_CACHE_HOME") or home / ".cache") / "mujoco_menagerie"


def wear_skin(spec: mujoco.MjSpec, description: Path) -> None:
    """Show the Menagerie's meshes instead of the arm's primitive shapes, which still collide but become invisible.

    Args:
        spec: A scene with the arm; it is changed.
        description: The Menagerie's ``panda.xml``.
    """
    source = mujoco.MjSpec.from_file(str(description))
    folder = description.parent / source.meshdir
    for number in range(8):
        link, model = spec.body(f"link{number}"), source.body(f"link{number}")
        shown = [geom for geom in model.geoms if geom.meshname and not geom.contype and not geom.conaffinity]
        for shape in link.geoms if shown else ():
            shape.group = HIDDEN
        for geom in shown:
            name = f"skin-{geom.meshname}"
            if spec.mesh(name) is None:
                mesh = source.mesh(geom.meshname)
                spec.add_mesh(name=name, file=str((folder / mesh.file).resolve()), scale=mesh.scale)
            material = source.material(geom.material)
            link.add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                pos=geom.pos,
                quat=geom.quat,
                rgba=geom.rgba if material is None else material.rgba,
                mass=0,
                contype=NOTHING,
                conaffinity=NOTHING,
            )
