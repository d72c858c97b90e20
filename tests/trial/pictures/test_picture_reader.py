"""Reading joints from pictures: what is plain to see is read rightly, and misreads come as pictures get coarser."""

import itertools

import numpy as np
import pytest
from drawn_board import HANDLES, coloured, in_depth

from lockprobe.trial.pictures.frame import from_png, to_png
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.pictures.picture_reader import evidence

ALL = list(itertools.product((0, 1), repeat=5))


def right(pictures, positions, acuity=64):
    """Evidence for the truth, from -1 to 1, of each joint."""
    return np.array(evidence(tuple(pictures), HANDLES, acuity=acuity)) * (2 * np.array(positions) - 1)


@pytest.mark.parametrize("kinds", [(coloured,), (in_depth,), (coloured, in_depth)])
def test_every_configuration_is_read_with_conviction(kinds):
    for seed, positions in enumerate(ALL[::10]):
        assert right([kind(positions, seed) for kind in kinds], positions).min() > 0.5


def test_misreads_come_as_pictures_get_coarser():
    drawn = [(coloured(positions, seed), positions) for seed, positions in enumerate(ALL[::5])]
    rates = [
        (np.array([right([picture], positions, acuity) for picture, positions in drawn]) < 0).mean()
        for acuity in (4, 6, 64)
    ]
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 0.15
    assert rates[-1] == 0


@pytest.mark.parametrize("kind", [coloured, in_depth])
def test_a_view_that_moved_is_read_rightly_where_pixels_are_small(kind):
    """Places are known where handles would be seen if the view had not moved."""
    apart = np.linalg.norm(np.subtract(*HANDLES[0]))
    for seed, positions in enumerate(ALL[5:-1:20]):
        picture = from_png(kind(positions, seed).png)
        for across, down in ((0.4, 0), (0, -0.4), (-0.3, 0.3)):
            shift = (round(down * apart), round(across * apart))
            moved = Picture(kind=kind(positions, seed).kind, png=to_png(np.roll(picture, shift, axis=(0, 1))))
            assert right([moved], positions, acuity=160).min() > 0.5
