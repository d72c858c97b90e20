"""What is taken from OpenCV: bits, tags in a picture, the board's pose, hand-eye."""

import io
import sys

import numpy as np
import pytest
from calibration import tagged
from calibration.tag_pictures import tag_bits
from lockprobe_robot.calibration import opencv
from lockprobe_robot.calibration.opencv import board_pose, find_tags, hand_eye, read_grey
from scipy.spatial.transform import Rotation

from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.trial.pictures.png import to_png


@pytest.fixture
def _cv2():
    pytest.importorskip("cv2")


def test_without_opencv_the_extra_is_named(monkeypatch):
    opencv._opencv.cache_clear()
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(Missing, match=r"lockprobe-robot\[calibrate\]"):
        read_grey(b"", "x.png")
    monkeypatch.setitem(sys.modules, "cv2", type(sys)("cv2"))
    sys.modules["cv2"].__version__ = "5.0.0"
    with pytest.raises(Missing, match="5.0.0 has no hand-eye calibration"):
        read_grey(b"", "x.png")


@pytest.mark.usefixtures("_cv2")
def test_tags_in_a_picture_have_their_number_and_corners():
    numbers = (3, 0, 200)
    picture = np.full((300, 600), 235, np.uint8)
    for place, cells in enumerate(tag_bits(numbers)):
        assert not cells[[0, -1]].any()
        assert not cells[:, [0, -1]].any()
        picture[100:196, 50 + 180 * place : 146 + 180 * place] = np.kron(cells * 235, np.ones((12, 12)))
    found = dict(find_tags(picture))
    assert sorted(found) == sorted(numbers)
    for place, number in enumerate(numbers):
        left = 50 + 180 * place - 0.5
        np.testing.assert_allclose(
            found[number], [(left, 99.5), (left + 96, 99.5), (left + 96, 195.5), (left, 195.5)], atol=0.3
        )
    assert find_tags(np.zeros((100, 100), np.uint8)) == []


@pytest.mark.usefixtures("_cv2")
def test_projected_corners_give_the_pose_back():
    _, tags = tagged.board()
    for view in tagged.views(5):
        points = tags.corners @ view.board[:3, :3].T + view.board[:3, 3]
        pixels = points[..., :2] / points[..., 2:] * tagged.CAMERA.focal + tagged.CAMERA.centre
        pose, error = board_pose(tags.corners, dict(enumerate(pixels)), tagged.CAMERA)
        np.testing.assert_allclose(pose, view.board, atol=1e-5)
        assert error < 1e-3
        pose, _ = board_pose(tags.corners, {0: pixels[0], 1: pixels[1], 3: pixels[3]}, tagged.CAMERA)
        np.testing.assert_allclose(pose, view.board, atol=1e-5)


@pytest.mark.usefixtures("_cv2")
def test_the_camera_is_found_where_nothing_is_noisy():
    seen = tagged.views()
    found = hand_eye([view.hand for view in seen], [view.board for view in seen])
    np.testing.assert_allclose(found, tagged.eye(), atol=1e-6)


@pytest.mark.usefixtures("_cv2")
def test_views_that_contradict_each_other_have_no_pose():
    """As with tags that were glued in each other's places. OpenCV gives a reflection."""
    seen = tagged.views()
    boards = [view.board.copy() for view in seen]
    for board, turn in zip(boards, Rotation.random(len(boards), random_state=0), strict=True):
        board[:3, :3] = turn.as_matrix()
    with pytest.raises(BadValue, match="or tags in their places: it finds no pose of the camera"):
        hand_eye([view.hand for view in seen], boards)


@pytest.mark.usefixtures("_cv2")
def test_only_pictures_are_read(tmp_path):
    grey = np.arange(64, dtype=np.uint8).reshape(8, 8)
    np.testing.assert_array_equal(read_grey(to_png(grey), tmp_path), grey)
    whole = to_png(np.zeros((64, 64, 3), np.uint8))
    for content in (b"", b"GIF89a", whole[:20], b"\xff\xd8\xff" + bytes(100)):
        with pytest.raises(BadFile):
            read_grey(content, tmp_path / "x.png")


def jpeg(grey, **options):
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(grey).save(file, "JPEG", quality=95, **options)
    return file.getvalue()


@pytest.mark.usefixtures("_cv2")
def test_a_photograph_that_was_taken_upright_keeps_its_pixels_where_the_lens_put_them(tmp_path):
    from PIL import Image

    grey = np.zeros((32, 64), np.uint8)
    grey[:, :16] = 255
    turned = Image.Exif()
    turned[0x0112] = 6
    found = read_grey(jpeg(grey, exif=turned), tmp_path / "x.jpg")
    assert found.shape == (32, 64)
    assert np.abs(found.astype(int) - grey).max() < 40


@pytest.mark.usefixtures("_cv2")
@pytest.mark.parametrize("form", ["png", "jpeg"])
def test_a_picture_of_enormous_size_is_refused_before_it_is_decoded(form, tmp_path):
    grey = np.zeros((32, 64), np.uint8)
    if form == "png":
        content = to_png(grey)
        content = content[:16] + (60_000).to_bytes(4) + (50_000).to_bytes(4) + content[24:]
    else:
        content = jpeg(grey)
        content = content.replace((32).to_bytes(2) + (64).to_bytes(2), (50_000).to_bytes(2) + (60_000).to_bytes(2), 1)
    with pytest.raises(BadFile, match="60000 x 50000 pixels; at most 67108864 in all"):
        read_grey(content, tmp_path / "x")
