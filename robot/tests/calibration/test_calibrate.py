"""Camera and board are found from known poses; what cannot be relied on is refused; the hold-out error is honest."""

import numpy as np
import pytest
from calibration import tagged
from lockprobe_robot.calibration import calibrate as library
from lockprobe_robot.calibration.calibrate import FEWEST_VIEWS, calibrate, turned_degrees
from lockprobe_robot.calibration.pose import array_of
from lockprobe_robot.calibration.views import Views

from lockprobe.foundation.errors import BadValue

REFUSED = {"bad.png": "2 of 4 tags seen (0, 1); 3 are needed"}


def calibrated(seen, **options):
    tags = tagged.board()[1]
    return calibrate(seen, REFUSED, camera=tagged.CAMERA, tags=tags, box=tagged.BOX, board="0" * 64, **options)


def test_without_noise_camera_and_board_are_found_and_held_out_views_agree():
    pytest.importorskip("cv2")
    found = calibrated(tagged.views())
    np.testing.assert_allclose(array_of(found.camera_in_hand), tagged.eye(), atol=1e-6)
    np.testing.assert_allclose(array_of(found.board_in_base), tagged.board()[0].pose, atol=1e-6)
    assert found.errors.held_out_worst_mm < 0.01
    assert found.refused == REFUSED
    assert len(found.used) == 12


def test_the_hold_out_error_grows_with_the_noise_and_is_no_smaller_than_the_error_of_the_board():
    pytest.importorskip("cv2")
    held, off = [], []
    for millimetres in (0.5, 2.0, 8.0):
        found = calibrated(tagged.views(16, millimetres=millimetres))
        held.append(found.errors.held_out_mm)
        off.append(1000 * np.linalg.norm((array_of(found.board_in_base) - tagged.board()[0].pose)[:3, 3]))
        assert found.errors.held_out_worst_mm > found.errors.held_out_mm
    assert held[0] < held[1] < held[2]
    assert (np.array(held) > off).all()


def test_a_single_wrong_view_shows_in_the_worst_error():
    pytest.importorskip("cv2")
    seen = tagged.views(16)
    seen[5].hand[:3, 3] += (0.03, 0, 0)
    found = calibrated(seen)
    assert found.errors.held_out_worst_mm > 20


def test_too_few_views_are_refused():
    with pytest.raises(
        BadValue, match=f"views with the board: got 7, expected at least {FEWEST_VIEWS}; 1 were refused"
    ):
        calibrated(tagged.views(7))


@pytest.mark.parametrize("turned", [{"tilt": 3.0, "roll": 3.0}, {"axes": "z"}, {"axes": "x"}], ids=str)
def test_little_rotation_and_rotation_about_one_axis_are_refused(turned):
    with pytest.raises(BadValue, match="rotation of the hand off its most frequent axis.*turn the hand about two axes"):
        calibrated(tagged.views(**turned))


def test_rotation_about_one_axis_counts_as_none():
    hands = [view.hand for view in tagged.views(axes="z")]
    assert turned_degrees(hands) == pytest.approx(0, abs=1e-3)
    assert turned_degrees([view.hand for view in tagged.views()]) > 20
    assert turned_degrees(hands[:1]) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(
    ("numbers", "refused"),
    [
        ((0, 1, 2), None),
        ((0, 1, 2, 9), None),
        ((0, 1, 9, 586), "2 of 4 tags seen (0, 1); 3 are needed"),
        ((0, 1, 2, 2), "a tag is seen twice (seen: 0, 1, 2, 2)"),
        ((), "0 of 4 tags seen (none); 3 are needed"),
    ],
)
def test_a_view_is_refused_by_the_tags_of_the_board_that_it_shows(numbers, refused, monkeypatch, tmp_path):
    """Tags of other things in the laboratory do not count."""
    (tmp_path / "0.png").touch()
    views = Views(camera=tagged.CAMERA, views=[{"picture": "0.png", "hand": np.eye(4).tolist()}])
    monkeypatch.setattr(library, "read_grey", lambda content, path: np.zeros((480, 640), np.uint8))
    monkeypatch.setattr(library, "find_tags", lambda grey: [(number, np.zeros((4, 2))) for number in numbers])
    monkeypatch.setattr(library, "board_pose", lambda corners, found, camera: (np.eye(4), 0.5))
    seen, reasons = library.look_at_views(tmp_path, views, tagged.board()[1])
    assert reasons == ({} if refused is None else {"0.png": refused})
    assert [view.tags for view in seen] == ([3] if refused is None else [])
