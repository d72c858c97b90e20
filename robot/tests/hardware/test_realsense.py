"""The depth camera's adapter: without a device, and on pictures that the library plays itself."""

import sys
import types

import numpy as np
import pytest
from lockprobe_robot.hardware.camera import Shot, check_shot
from lockprobe_robot.hardware.realsense import PlayedRealSense, RealSense

from lockprobe.foundation.errors import Missing, PlantFault


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(Missing, match=r"lockprobe-robot\[realsense\]"):
        RealSense()


def test_without_a_camera_it_is_said_in_one_line():
    pytest.importorskip("pyrealsense2")
    with pytest.raises(Missing, match="RealSense camera 123 is not connected"):
        RealSense("123")


class Frames:
    def get_color_frame(self):
        return types.SimpleNamespace(get_data=lambda: np.full((4, 6, 3), 7, np.uint8))

    def get_depth_frame(self):
        return types.SimpleNamespace(get_data=lambda: np.full((4, 6), 720, np.uint16))


def opened(wait):
    camera = RealSense.__new__(RealSense)
    camera._serial, camera._metres = "123", 0.001
    camera._source = types.SimpleNamespace(wait_for_frames=wait, stop=lambda: None)
    camera._align = types.SimpleNamespace(process=lambda frames: frames)
    return camera


def test_depth_is_in_metres():
    shot = opened(lambda timeout: Frames()).grab()
    assert shot.rgb.shape == (4, 6, 3)
    assert shot.depth == pytest.approx(np.full((4, 6), 0.72))


def test_a_camera_that_is_unplugged_is_a_fault():
    def gone(timeout):
        raise RuntimeError("Frame didn't arrive within 2000")

    with pytest.raises(PlantFault, match="gives no picture .Frame didn't arrive"):
        opened(gone).grab()


def test_the_library_has_the_names_that_are_called():
    rs = pytest.importorskip("pyrealsense2")
    assert all(
        hasattr(rs, name) for name in ["context", "config", "pipeline", "align", "stream", "format", "camera_info"]
    )
    assert hasattr(rs.device, "first_depth_sensor")
    assert hasattr(rs.depth_sensor, "get_depth_scale")


def test_played_pictures_come_through_the_library_as_they_are_and_never_an_old_one():
    pytest.importorskip("pyrealsense2")
    luck, taken = np.random.default_rng(1), []

    def take():
        depth = (luck.integers(500, 900) + np.arange(64) + np.zeros((48, 1))).astype(np.float32) / 1000
        taken.append(Shot(rgb=luck.integers(0, 256, (48, 64, 3), dtype=np.uint8), depth=depth))
        return taken[-1]

    camera = PlayedRealSense(take, width=64, height=48)
    for at in range(1, 4):
        shot = check_shot(camera.grab(), (64, 48))
        assert len(taken) == at
        assert (shot.rgb == taken[-1].rgb).all()
        there = shot.depth > 0  # aligning loses some pixels to rounding
        assert there.mean() > 0.9
        assert shot.depth[there] == pytest.approx(taken[-1].depth[there], abs=0.0011)  # or the pixel next to it
    assert camera.facts == {"camera": "realsense software_device"}
    camera.close()


def test_without_the_library_nothing_is_played(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(Missing, match=r"lockprobe-robot\[realsense\]"):
        PlayedRealSense(lambda: None)
