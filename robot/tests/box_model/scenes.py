"""Scenes for tests, compiled."""

import numpy as np
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import build_scene
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.box import Joint, Lockbox

LABELS = "ABCDEFGH"


def scene_of(box, seed=1, **settings):
    labels = tuple(LABELS[: len(box.joints)])
    return build_scene(box, labels=labels, settings=SceneSettings(**settings), rng=np.random.default_rng(seed))


def mechanism_of(box, **settings):
    return Mechanism(scene_of(box, **settings))


def two_joints(locked, by, *, clauses=({"b": True},), places=((0.25, 0.5), (0.75, 0.5))):
    """Two joints of given kinds, the first of which the second locks."""
    return Lockbox(
        name="two",
        joints=(Joint(name="a", kind=locked, place=places[0]), Joint(name="b", kind=by, place=places[1])),
        interlock={"a": clauses},
        initial=(False, False),
        target="a",
    )
