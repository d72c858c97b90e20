"""Noise of depth: as large as stated, with the same luck at every size, and none where none is asked for."""

import numpy as np
import pytest

from lockprobe.plants.rendering.depth_sensor import sense_depth

FLAT = np.full((120, 160), 0.7, np.float32)


def sensed(depth, noise, seed=1):
    return sense_depth(depth.astype(np.float32), noise, np.random.default_rng(seed))


def test_without_noise_only_millimetres_are_rounded():
    depth = np.linspace(0.5, 0.9, 500, dtype=np.float32).reshape(20, 25)
    read = sensed(depth, 0.0)
    assert np.abs(read - depth).max() <= 0.000501
    np.testing.assert_allclose(read * 1000, np.rint(read * 1000), atol=1e-3)
    assert (read > 0).all()


@pytest.mark.parametrize("noise", [0.0, 0.0012, 0.05])
def test_equally_much_is_drawn_whatever_the_noise_is(noise):
    rng = np.random.default_rng(3)
    sense_depth(FLAT, noise, rng)
    other = np.random.default_rng(3)
    sense_depth(FLAT, 0.01, other)
    assert rng.random() == other.random()


def test_its_size_is_as_stated_and_grows_with_the_square_of_depth():
    assert np.std(sensed(FLAT, 0.004)) == pytest.approx(0.004, rel=0.03)
    assert np.std(sensed(2 * FLAT, 0.004)) == pytest.approx(0.016, rel=0.03)


def test_larger_noise_is_the_same_luck_enlarged():
    small, large = (sensed(FLAT, noise) - 0.7 for noise in (0.004, 0.008))
    assert np.abs(large - 2 * small).max() < 0.0016


def test_holes_are_along_edges_only():
    depth = FLAT.copy()
    depth[:, 80:] = 0.8
    lost = sensed(depth, 0.001) == 0
    assert lost[:, 79:81].mean() == pytest.approx(0.6, abs=0.1)
    assert not lost[:, :79].any()
    assert not lost[:, 81:].any()
    assert (sensed(depth, 0.0) > 0).all()


def test_nothing_stays_nothing():
    depth = FLAT.copy()
    depth[:60] = 0
    assert not sensed(depth, 0.01)[:59].any()
