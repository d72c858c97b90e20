"""Looks are drawn alike whatever they are, and plain ones never differ."""

import numpy as np

from lockprobe.plants.scene.appearance import HANDLES, look_of


def rng(seed):
    return np.random.default_rng(seed)


def test_plain_looks_are_always_the_same():
    assert look_of("plain", rng(1)) == look_of("plain", rng(2))


def test_varied_looks_depend_on_the_seed_alone():
    assert look_of("varied", rng(3)) == look_of("varied", rng(3))
    drawn = [look_of("varied", rng(seed)) for seed in range(60)]
    assert len({look.knob for look in drawn}) == 60
    assert {look.handle for look in drawn} == set(HANDLES)
    assert all(np.abs(look.camera).max() <= 0.03 and 0.7 < look.brightness < 1.3 for look in drawn)


def test_as_many_numbers_are_drawn_for_either():
    first, second = rng(4), rng(4)
    look_of("plain", first)
    look_of("varied", second)
    assert first.random() == second.random()


def test_handles_stand_out_from_their_bars():
    for seed in range(60):
        look = look_of("varied", rng(seed))
        assert np.abs(np.array(look.knob) - look.bar).max() > 0.25
