"""The way of a handle: measured by length, straight on beyond its ends."""

import numpy as np
import pytest

from lockprobe.plants.arm.path import Path

DOWN = np.array([0.0, 0.0, -1.0])
ANGLES = np.linspace(0, 1.4, 33)
ARC = Path(points=0.06 * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES], axis=1), axis=DOWN)


def test_a_fine_polygon_is_as_long_as_its_arc():
    assert ARC.length == pytest.approx(0.06 * 1.4, rel=1e-4)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.999, 1.0])
def test_what_lies_on_the_path_has_travelled_as_far_as_it_lies_from_the_start(share):
    point, direction = ARC.at(share * ARC.length)
    assert ARC.travelled(point) == pytest.approx(share * ARC.length, abs=1e-9)
    assert np.linalg.norm(direction) == pytest.approx(1)


def test_a_point_beside_the_path_has_travelled_as_far_as_the_nearest_on_it():
    point, direction = ARC.at(0.04)
    beside = point + 0.004 * np.cross(direction, DOWN) + 0.01 * DOWN
    assert ARC.travelled(beside) == pytest.approx(0.04, abs=2e-3)


def test_beyond_its_ends_the_path_goes_straight_on_and_so_does_what_is_travelled():
    for distance in (-0.01, ARC.length + 0.006):
        assert ARC.travelled(ARC.at(distance)[0]) == pytest.approx(distance)
    (before, along), (end, _) = ARC.at(ARC.length - 1e-6), ARC.at(ARC.length + 0.006)
    assert np.allclose(end - before, 0.006001 * along, atol=1e-8)
