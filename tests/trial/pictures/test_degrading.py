"""Worse pictures: each dose does what it says, nests, and leaves the rest alone."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.trial.pictures.degrading import Damage, degraded
from lockprobe.trial.pictures.frame import Camera, Frame

PANEL = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.72], [0, 0, 0, 1.0]])
CAMERA = Camera(width=160, height=120, focal=200.0, panel=PANEL)
HANDLES = np.array([[[x, -0.04, 0.05], [x, 0.04, 0.05]] for x in (-0.15, 0.0, 0.15)])
RNG = np.random.default_rng(4)
FRAME = Frame(
    rgb=RNG.integers(60, 200, (120, 160, 3), dtype=np.uint8),
    depth=RNG.uniform(0.65, 0.77, (120, 160)).astype(np.float32),
    camera=CAMERA,
    handles=HANDLES,
    renderer="a fake",
)
LUCK = np.array([0.3, 0.8, 0.5])


def test_no_damage_is_the_same_picture():
    assert degraded(FRAME, Damage(), LUCK) is FRAME


@pytest.mark.parametrize("blur", [1.0, 3.0])
def test_blur_evens_out_and_keeps_the_mean(blur):
    worse = degraded(FRAME, Damage(blur=blur), LUCK)
    assert worse.rgb.std() < FRAME.rgb.std() / (2 * blur)
    assert worse.rgb.mean() == pytest.approx(FRAME.rgb.mean(), abs=1)
    np.testing.assert_array_equal(worse.depth, FRAME.depth)


def test_noise_has_the_size_that_it_says_and_is_the_same_noise_at_every_size():
    grey = replace(FRAME, rgb=np.full_like(FRAME.rgb, 128))
    small, large = (degraded(grey, Damage(noise=noise), LUCK).rgb.astype(float) - 128 for noise in (0.05, 0.1))
    assert small.std() == pytest.approx(0.05 * 255, rel=0.02)
    assert large.std() == pytest.approx(0.1 * 255, rel=0.02)
    assert np.abs(large - 2 * small).max() <= 1.5
    other = degraded(grey, Damage(noise=0.05), np.array([0.3, 0.8, 0.6])).rgb
    assert (other != small + 128).mean() > 0.5


def test_the_patch_hides_its_share_of_the_panel_and_what_a_smaller_one_hides():
    hidden = []
    for share in (0.1, 0.4, 0.9, 1.0):
        worse = degraded(FRAME, Damage(occlude=share), LUCK)
        gone = worse.depth == 0
        assert (worse.rgb[gone] == 128).all()
        np.testing.assert_array_equal(worse.rgb[~gone], FRAME.rgb[~gone])
        np.testing.assert_array_equal(worse.depth[~gone], FRAME.depth[~gone])
        hidden.append(gone)
    for less, more in pairwise(hidden):
        assert (more | ~less).all()
    whole = hidden[-1].sum()
    for share, gone in zip((0.1, 0.4, 0.9), hidden, strict=False):
        assert gone.sum() / whole == pytest.approx(share, rel=0.05)
    places = CAMERA.project(HANDLES)[..., :2].reshape(-1, 2).round().astype(int)
    assert all(hidden[-1][row, column] for column, row in places)


def test_a_stop_is_twice_the_light_and_what_is_too_bright_is_clipped():
    greys = replace(FRAME, rgb=np.broadcast_to(np.arange(160, dtype=np.uint8)[:, None] + 96, FRAME.rgb.shape))
    seen = {stops: degraded(greys, Damage(exposure=stops), LUCK) for stops in (-20, -2, -1, 1, 2, 20)}
    assert (seen[-1].rgb[greys.rgb == 255] == 188).all()  # half the light, as sRGB codes it
    assert (seen[1].rgb[greys.rgb >= 189] == 255).all()
    for fewer, more in pairwise(seen.values()):
        assert (fewer.rgb <= more.rgb).all()
    twice = degraded(seen[-1], Damage(exposure=-1), LUCK).rgb.astype(int)
    assert np.abs(twice - seen[-2].rgb).max() <= 1
    assert (seen[-20].rgb.max(), seen[20].rgb.min()) == (0, 255)
    assert all((worse.depth == FRAME.depth).all() for worse in seen.values())


def test_noise_is_the_sensor_s_whatever_the_exposure_is():
    dark = degraded(FRAME, Damage(exposure=-20, noise=0.1), LUCK).rgb
    assert (dark > 0).mean() == pytest.approx(0.5, abs=0.03)


def test_where_the_patch_lies_is_luck():
    here, there = (degraded(FRAME, Damage(occlude=0.2), np.array(luck)) for luck in ((0, 0, 0), (0.9, 0.9, 0)))
    assert not ((here.depth == 0) & (there.depth == 0)).all()
    assert (here.depth == 0).sum() == pytest.approx((there.depth == 0).sum(), rel=0.05)


@pytest.mark.parametrize(
    ("name", "value"), [("blur", -1), ("noise", float("nan")), ("occlude", 1.5), ("occlude", -0.1)]
)
def test_doses_out_of_range_are_refused(name, value):
    with pytest.raises(BadValue, match=f"^{name}: got {value}, expected a number from 0"):
        Damage(**{name: value})
    with pytest.raises(BadValue, match="^exposure: got .*, expected a number from -20 to 20"):
        Damage(exposure=300 * value)
