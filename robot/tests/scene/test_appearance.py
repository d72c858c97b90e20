"""Looks are drawn alike whatever they are, and plain ones never differ."""

import numpy as np
from lockprobe_robot.scene.appearance import HANDLES, appearance_of


def rng(seed):
    return np.random.default_rng(seed)


def test_plain_looks_are_always_the_same():
    assert appearance_of("plain", rng(1)) == appearance_of("plain", rng(2))


def test_varied_looks_depend_on_the_seed_alone():
    assert appearance_of("varied", rng(3)) == appearance_of("varied", rng(3))
    drawn = [appearance_of("varied", rng(seed)) for seed in range(60)]
    assert len({appearance.knob for appearance in drawn}) == 60
    assert {appearance.handle for appearance in drawn} == set(HANDLES)
    assert all(np.abs(appearance.camera).max() <= 0.03 and 0.7 < appearance.brightness < 1.3 for appearance in drawn)


def test_as_many_numbers_are_drawn_for_either():
    first, second = rng(4), rng(4)
    appearance_of("plain", first)
    appearance_of("varied", second)
    assert first.random() == second.random()


def test_handles_stand_out_from_their_bars():
    for seed in range(60):
        appearance = appearance_of("varied", rng(seed))
        assert np.abs(np.array(appearance.knob) - appearance.bar).max() > 0.25
