"""What agents saw: which pictures a page shows, and how small."""

import base64

import numpy as np
from builders import make_trial

from lockprobe.pictures.png import from_png, to_png
from lockprobe.report.sample_pictures import SeenModality, SeenMoment, embedded, seen


def saw(*files):
    """A row with a moment for each of these files."""
    return SeenModality(modality="rgb", key="", moments=[SeenMoment(when="", text="", files=one) for one in files])


def shown_small(directory, name, kind, pixels):
    """A picture as a page would show it."""
    (directory / "pictures").mkdir(exist_ok=True)
    (directory / "pictures" / name).write_bytes(to_png(pixels))
    found = embedded(directory, [saw({kind: name})])
    assert list(found) == [name]
    return from_png(base64.b64decode(found[name].partition(",")[2]))


def test_no_picture_is_shown_that_only_the_record_needs(modal, picture_names):
    rows = seen(modal)
    assert [row.modality for row in rows] == ["rgb", "rgbd"]
    assert [moment.files for moment in rows[1].moments] == [
        {"rgb": picture_names[0], "depth": picture_names[2]},
        {"rgb": picture_names[1], "depth": picture_names[4]},
    ]
    assert rows[0].moments[1].when == "after step 1: revolute-left did not move"


def test_the_first_move_is_shown_too(picture_names):
    (row,) = seen(
        [make_trial([0, 3], budget=2, modality="rgb", pictures=[{"rgb": name} for name in picture_names[:3]])]
    )
    assert [moment.when for moment in row.moments] == [
        "before the first step", "after step 1: revolute-left did not move", "after step 2: revolute-right moved",
    ]  # fmt: skip
    (row,) = seen([make_trial([3], budget=1, modality="rgb", pictures=[{"rgb": name} for name in picture_names[:2]])])
    assert len(row.moments) == 2


def test_pictures_that_are_lost_or_lie_elsewhere_are_left_out(tmp_path, picture_names):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "secret.png").write_bytes(to_png(np.zeros((8, 8), np.uint8)))
    (tmp_path / "pictures" / picture_names[1]).write_bytes(b"torn")
    rows = [saw(*({"rgb": name} for name in ("../secret.png", *picture_names[:2])))]
    assert embedded(tmp_path, rows) == {}


def test_colours_are_made_small_by_averaging(tmp_path, picture_names):
    even = np.full((301, 700, 3), 9, np.uint8)
    even[:, ::3] = 12
    small = shown_small(tmp_path, picture_names[0], "rgb", even)
    assert small.shape == (100, 233, 3)
    assert (small == 10).all()


def test_depth_is_made_small_without_making_new_codes(tmp_path, picture_names):
    """Codes of depth that alternate: their mean would be that of another depth."""
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[..., 0], pixels[..., 2] = 4, 248
    pixels[::2, ::3, 0], pixels[::2, ::3, 2] = 8, 0
    small = shown_small(tmp_path, picture_names[2], "depth", pixels)
    assert small.shape == (240, 320, 3)
    assert {tuple(code) for code in small.reshape(-1, 3).tolist()} <= {(4, 0, 248), (8, 0, 0)}
    grey = shown_small(tmp_path, picture_names[2], "depth", pixels[..., 0])
    assert grey.shape == (240, 320)


def test_a_small_picture_stays_as_it_is(tmp_path, picture_names):
    pixels = np.random.default_rng(3).integers(0, 256, (30, 40, 3)).astype(np.uint8)
    for kind in ("rgb", "depth"):
        np.testing.assert_array_equal(shown_small(tmp_path, picture_names[1], kind, pixels), pixels)
