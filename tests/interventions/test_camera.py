"""The camera shows the box and says nothing about it."""

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.camera import FAR, NEAR, CameraChannel
from lockprobe.trial.pictures.frame import Camera, Frame, from_png, turbo
from lockprobe.trial.record import Percept, Task

TASK = Task(joints=("B", "A"), target="A", budget=20)
PANEL = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.72], [0, 0, 0, 1.0]])
CAMERA = Camera(width=40, height=30, focal=50.0, panel=PANEL)
HANDLES = np.array([[[0, 0, 0.05], [0, 0.06, 0.05]], [[0.1, 0, 0.05], [0.16, 0, 0.05]]])
RNG = np.random.default_rng(4)
FRAME = Frame(
    rgb=RNG.integers(0, 256, (30, 40, 3), dtype=np.uint8),
    depth=np.where(RNG.random((30, 40)) < 0.1, 0, RNG.uniform(0.65, 0.77, (30, 40))).astype(np.float32),
    camera=CAMERA,
    handles=HANDLES,
    renderer="a fake",
)
MOVED = Percept(joint="B", outcome="moved", positions=(True, False), look=lambda positions: FRAME)


def told(percept, channel):
    return channel.perceive(percept, (), TASK, np.random.default_rng(1))


def decode(image):
    """The inverse of ``encode``, to within half a colour; 0 where there is no reading, or no colour of the scale."""
    weights = np.array([65536, 256, 1])
    colours, asked = turbo().astype(np.int64) @ weights, image.astype(np.int64) @ weights
    order = np.argsort(colours)
    level = order[np.clip(np.searchsorted(colours[order], asked), 0, 255)]
    known = colours[level] == asked
    return np.where(known, FAR + level / 255 * (NEAR - FAR), 0).astype(np.float32)


@pytest.mark.parametrize("depth", [False, True])
def test_what_happened_is_not_told(depth):
    blocked = Percept(joint="B", outcome="blocked", positions=(False, True), look=lambda positions: FRAME)
    moved, same = told(MOVED, CameraChannel(depth=depth)), told(blocked, CameraChannel(depth=depth))
    assert (moved.outcome, moved.positions, moved.joint) == (None, None, "B")
    assert moved.text == same.text
    assert moved.pictures == same.pictures


def test_rgbd_adds_depth_as_shown_and_as_measured():
    channel = CameraChannel(depth=True)
    percept = told(MOVED, channel)
    first = told(Percept(positions=(True, False), look=lambda positions: FRAME), channel)
    assert first.text.startswith("The first picture shows the box, the second its depth. ")
    assert percept.text == "You attempted B. The first picture shows the box now, the second its depth."
    assert [(picture.kind, picture.shown) for picture in percept.pictures] == [
        ("rgb", True),
        ("depth", True),
        ("depth16", False),
    ]
    millimetres = from_png(percept.pictures[2].png)
    assert millimetres.dtype == np.uint16
    assert np.abs(millimetres / 1000 - FRAME.depth).max() < 0.00051
    read = decode(from_png(percept.pictures[1].png))
    np.testing.assert_array_equal(read == 0, millimetres == 0)
    assert np.abs(read - millimetres / 1000).max() < 0.0007


@pytest.mark.parametrize("depth", [False, True])
def test_pictures_are_degraded_by_every_dose(depth):
    plain = told(MOVED, CameraChannel(depth=depth))
    assert told(MOVED, CameraChannel(depth=depth, blur=0, noise=0, occlude=0, exposure=0)).pictures == plain.pictures
    for name, dose in {"blur": 2, "noise": 0.1, "occlude": 0.5, "exposure": 1}.items():
        worse = told(MOVED, CameraChannel(depth=depth, **{name: dose}))
        assert worse.pictures[0] != plain.pictures[0]
        assert (worse.pictures[1:] == plain.pictures[1:]) == (name != "occlude" or not depth)
        assert worse.handles == plain.handles


@pytest.mark.parametrize(("depth", "modality"), [(False, "rgb"), (True, "rgbd")])
def test_without_a_camera_it_says_which_plants_have_one(depth, modality):
    said = f"modality: got '{modality}', expected symbolic, or a plant with a camera: fast-twin or twin"
    with pytest.raises(BadValue, match=said):
        told(Percept(positions=(True, False)), CameraChannel(depth=depth))
