"""Where things of the panel are seen, and how high above it what is seen is."""

import numpy as np
import pytest

from lockprobe.trial.pictures.frame import Camera


def tilted(angle=0.35, distance=0.72):
    """A camera whose axis meets the middle of a panel that leans away from it."""
    panel = np.eye(4)
    panel[:3, :3] = np.array([[1, 0, 0], [0, -np.cos(angle), np.sin(angle)], [0, -np.sin(angle), -np.cos(angle)]])
    panel[:3, 3] = [0.01, -0.02, distance]
    return Camera(width=64, height=48, focal=60.0, panel=panel)


def test_the_middle_of_the_panel_is_seen_in_the_middle():
    panel = np.diag([1.0, -1, -1, 1])
    panel[2, 3] = 0.7
    camera = Camera(width=640, height=480, focal=600, panel=panel)
    assert camera.project(np.zeros(3)) == pytest.approx([319.5, 239.5, 0.7])
    # Right on the panel is right in the picture, up is up, and what stands out is nearer.
    assert camera.project(np.array([0.1, 0.05, 0.07])) == pytest.approx([319.5 + 60 / 0.63, 239.5 - 30 / 0.63, 0.63])
    assert camera.project(np.zeros((4, 2, 3))).shape == (4, 2, 3)


def test_heights_are_those_of_points_that_are_projected():
    camera = tilted()
    points = np.random.default_rng(2).uniform([-0.2, -0.15, -0.02], [0.2, 0.15, 0.06], (200, 3))
    column, row, depth = camera.project(points).T
    inside = (np.abs(column - 31.5) < 31) & (np.abs(row - 23.5) < 23)
    assert inside.sum() > 50
    # Heights are computed at the middles of pixels, so a point is moved to the middle of its own first.
    for c, r, z in zip(np.rint(column[inside]), np.rint(row[inside]), depth[inside], strict=True):
        seen = np.array([(c - 31.5) / 60, (r - 23.5) / 60, 1]) * z
        expected = (np.linalg.inv(camera.panel) @ [*seen, 1])[2]
        assert camera.heights(np.full((48, 64), z))[int(r), int(c)] == pytest.approx(expected, abs=1e-12)
