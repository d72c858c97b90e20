"""A folder of views is untrusted: what is wrong ends in one line."""

import json

import numpy as np
import pytest
from lockprobe_robot.calibration.views import VIEWS_FILE, read_picture, read_views

from lockprobe.foundation.errors import BadFile

CAMERA = {"width": 640, "height": 480, "focal": [433, 433.5], "centre": [319.5, 239.5]}
VIEW = {"picture": "00.png", "hand": np.eye(4).tolist()}


def folder(tmp_path, camera=None, views=None, **more):
    content = {"camera": CAMERA | (camera or {}), "views": [VIEW] if views is None else views} | more
    (tmp_path / VIEWS_FILE).write_text(json.dumps(content), "utf-8")
    return tmp_path


def test_a_file_is_read(tmp_path):
    found = read_views(folder(tmp_path, {"distortion": [0.1, 0, 0, 0]}))
    np.testing.assert_array_equal(found.camera.matrix, [[433, 0, 319.5], [0, 433.5, 239.5], [0, 0, 1]])
    np.testing.assert_array_equal(found.views[0].pose, np.eye(4))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"views": []}, "views: .*at least 1"),
        ({"views": [VIEW, VIEW]}, "names the picture 00.png twice"),
        ({"views": [VIEW | {"picture": "../00.png"}]}, "views.0.picture: expected the name of a file in the folder"),
        ({"views": [VIEW | {"picture": "a/b.png"}]}, "views.0.picture: expected the name of a file in the folder"),
        ({"views": [VIEW | {"picture": "\x1b[2J.png"}]}, "views.0.picture: expected the name of a file in the folder"),
        ({"views": [VIEW | {"hand": [[1, 0, 0, 0]] * 4}]}, "views.0.hand: expected four rows of a rigid pose"),
        ({"views": [VIEW | {"hand": [1] * 16}]}, "views.0.hand"),
        ({"views": [VIEW | {"extra": 1}]}, "views.0.extra: no such key"),
        ({"camera": {"focal": [0, 1]}}, "camera.focal.0: .*greater than 0"),
        ({"camera": {"focal": [float("nan"), 1]}}, "camera.focal.0: .*finite"),
        ({"camera": {"width": 10**9}}, "camera.width: .*at most 8192"),
        ({"camera": {"distortion": [0, 0, 0]}}, "camera.distortion: 3 numbers; expected none, 4, 5 or 8"),
        ({"more": 1}, "more: no such key"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, wrong, message):
    with pytest.raises(BadFile, match=message) as caught:
        read_views(folder(tmp_path, **wrong))
    assert "\n" not in str(caught.value)
    assert "\x1b" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b"\xff", b"null", b"[" * 10_000])
def test_what_is_no_such_file_is_refused(tmp_path, content):
    (tmp_path / VIEWS_FILE).write_bytes(content)
    with pytest.raises(BadFile):
        read_views(tmp_path)


def test_a_missing_folder_or_picture_is_named(tmp_path):
    with pytest.raises(BadFile, match=r"none.views\.json: cannot be read"):
        read_views(tmp_path / "none")
    with pytest.raises(BadFile, match=r"00\.png: cannot be read"):
        read_picture(tmp_path, read_views(folder(tmp_path)).views[0])
