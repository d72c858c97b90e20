"""The depth camera's adapter, without a device."""

import sys
import types

import numpy as np
import pytest
from lockprobe_robot.hardware.realsense import RealSense

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
