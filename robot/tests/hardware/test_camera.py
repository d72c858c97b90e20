"""A folder as a camera: the newest picture, once."""

import numpy as np
import pytest
from lockprobe_robot.hardware.camera import FolderCamera, Shot, check_shot
from PIL import Image

from lockprobe.foundation.errors import BadFile, PlantFault

RED = np.full((40, 60, 3), (200, 20, 10), dtype=np.uint8)


def test_a_picture_is_used_once_and_older_ones_never(tmp_path):
    Image.fromarray(RED).save(tmp_path / "old.png")
    camera = FolderCamera(tmp_path)
    with pytest.raises(PlantFault, match="there is no new picture"):
        camera.grab()
    Image.fromarray(RED // 2).save(tmp_path / "a.png")
    assert np.array_equal(camera.grab().rgb, RED // 2)
    (tmp_path / "notes.txt").write_text("no picture")
    with pytest.raises(PlantFault, match="there is no new picture"):
        camera.grab()
    Image.fromarray(RED[:20]).save(tmp_path / "a.png")
    assert camera.grab().rgb.shape == (20, 60, 3)


def test_a_photo_is_turned_as_viewers_show_it(tmp_path):
    camera = FolderCamera(tmp_path)
    exif = Image.Exif()
    exif[0x0112] = 6  # held upright
    Image.fromarray(RED).save(tmp_path / "phone.JPG", exif=exif)
    assert camera.grab().rgb.shape == (60, 40, 3)


def test_a_half_written_picture_is_refused_and_may_come_whole_later(tmp_path):
    camera = FolderCamera(tmp_path)
    Image.fromarray(RED).save(tmp_path / "a.png")
    whole = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(whole[:60])
    with pytest.raises(PlantFault, match="is no whole PNG or JPEG picture"):
        camera.grab()
    (tmp_path / "a.png").write_bytes(whole)
    assert camera.grab().rgb.shape == RED.shape


def test_no_folder_and_a_folder_that_vanishes(tmp_path):
    with pytest.raises(BadFile, match="no such folder"):
        FolderCamera(tmp_path / "none")
    (tmp_path / "here").mkdir()
    camera = FolderCamera(tmp_path / "here")
    (tmp_path / "here").rmdir()
    with pytest.raises(PlantFault, match="cannot be read"):
        camera.grab()


@pytest.mark.parametrize(
    ("shot", "size", "why"),
    [
        (Shot(rgb=RED[..., 0]), None, "expected height x width x 3"),
        (Shot(rgb=RED.astype(float)), None, "of float64"),
        (Shot(rgb=RED, depth=np.zeros((4, 4), np.float32)), None, "align them"),
        (Shot(rgb=RED), (640, 480), "a picture has 60 x 40 pixels, expected 640 x 480"),
    ],
)
def test_a_shot_of_the_wrong_shape_is_a_fault(shot, size, why):
    with pytest.raises(PlantFault, match=why):
        check_shot(shot, size)
