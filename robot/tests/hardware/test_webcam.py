"""A webcam gives fresh pictures in RGB; one that is not there is one line."""

import sys

import numpy as np
import pytest
from hardware.webcams import FakeCapture, fake_cv2
from lockprobe_robot.hardware.webcam import Webcam

from lockprobe.foundation.errors import Missing, PlantFault

RED = np.full((40, 60, 3), (200, 20, 10), dtype=np.uint8)


def test_stale_frames_are_dropped_and_colours_are_in_the_order_of_pictures(monkeypatch):
    capture = FakeCapture(lambda: RED)
    monkeypatch.setitem(sys.modules, "cv2", fake_cv2(capture))
    webcam = Webcam(1)
    assert np.array_equal(webcam.grab().rgb, RED)
    assert capture.grabbed == 5
    assert webcam.facts == {"camera": "webcam 1"}
    webcam.close()
    assert capture.released


def test_a_webcam_that_gives_no_picture_is_a_fault(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", fake_cv2(FakeCapture(lambda: None)))
    with pytest.raises(PlantFault, match="webcam 0 gives no picture"):
        Webcam().grab()


def test_a_webcam_that_is_not_there_is_one_line(capfd):
    pytest.importorskip("cv2")
    with pytest.raises(Missing, match="webcam 63 cannot be opened: plug it in, or give a folder: --camera FOLDER"):
        Webcam(63)
    assert capfd.readouterr().err == ""
