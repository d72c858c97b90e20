"""Pictures as arrays."""

import numpy as np
import pytest

from lockprobe.environment.pictures import colours, distances, images, stacked
from lockprobe.errors import ChannelFault
from lockprobe.pictures.picture import Picture
from lockprobe.pictures.png import to_png
from lockprobe.record import Percept

RGB = np.arange(6 * 5 * 3, dtype=np.uint8).reshape(6, 5, 3)
MILLIMETRES = np.arange(6 * 5, dtype=np.uint16).reshape(6, 5) * 200


def percept(rgb=RGB):
    return Percept(
        pictures=(
            Picture(kind="rgb", png=to_png(rgb)),
            Picture(kind="depth", png=to_png(rgb)),
            Picture(kind="depth16", png=to_png(MILLIMETRES), shown=False),
        )
    )


def test_colours_come_back_as_they_went():
    assert (colours(percept()) == RGB).all()
    assert colours(percept()).dtype == np.uint8


def test_depth_is_what_was_measured_up_to_its_limit():
    metres = distances(percept())
    assert (metres.shape, metres.dtype) == ((6, 5, 1), np.float32)
    assert metres.ravel()[:21].tolist() == pytest.approx([0.2 * i for i in range(21)])
    assert metres.ravel()[21:].max() == 0


def test_an_observation_is_colours_or_both():
    assert (images(percept(), "rgb") == RGB).all()
    assert sorted(images(percept(), "rgbd")) == ["depth", "rgb"]
    assert stacked([percept(), percept(RGB + 1)], "rgb").shape == (2, 6, 5, 3)
    both = stacked([percept(), percept(RGB + 1)], "rgbd")
    assert (both["rgb"][1] == RGB + 1).all()
    assert both["depth"].shape == (2, 6, 5, 1)


def test_what_is_not_there_is_no_picture():
    with pytest.raises(ChannelFault, match="no picture of the kind rgb"):
        colours(Percept())
