"""The arm's outer shape from MuJoCo Menagerie, where its user has it. It is seen and changes no physics.

Nothing is downloaded: it is taken from a checkout of one's own that ``MENAGERIE_ROOT`` names, or from what the package
``mujoco-menagerie`` has stored before (in ``MENAGERIE_CACHE_DIR``, or where it does so by itself).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

import mujoco

from lockprobe.plants.layers import HIDDEN, NOTHING

__all__ = ["find_skin", "wear_skin"]

_ROBOT = "franka_emika_panda"


def find_skin(environment: Mapping[str, str] = os.environ) -> Path | None:
    """The Menagerie's description of the Panda on this machine, or None if it has none.

    Args:
        environment: Where variables are read.
    """
    if root := environment.get("MENAGERIE_ROOT"):
        places = [Path(root) / _ROBOT]
    else:
        stored = Path(environment.get("MENAGERIE_CACHE_DIR") or _stored(environment)) / "models"
        places = [path.parent for path in sorted(stored.glob(f"{_ROBOT}-*/.complete"))]
    return next((path for place in places if (path := place / "panda.xml").is_file()), None)


def _stored(environment: Mapping[str, str]) -> Path:
    """Where the package stores models if nothing else is said."""
    home = Path(environment.get("HOME") or Path.home())
    if sys.platform == "win32":
        return Path(environment.get("LOCALAPPDATA") or home / "AppData/Local") / "mujoco_menagerie" / "cache"
    if sys.platform == "darwin":
        return home / "Library/Caches/mujoco_menagerie"
    return Path(environment.get("XDG_CACHE_HOME") or home / ".cache") / "mujoco_menagerie"


def wear_skin(spec: mujoco.MjSpec, description: Path) -> None:
    """Show the Menagerie's meshes in place of the arm's own shapes, which go on colliding unseen.

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
