"""Looks are drawn alike whatever they are, plain ones never differ, and a single factor changes its own part alone."""

from dataclasses import fields

import numpy as np
import pytest
from lockprobe_robot.box_model.appearance import HANDLES, appearance_of
from lockprobe_robot.twin_settings import SceneSettings


def drawn_look(seed, **settings):
    return appearance_of(SceneSettings(**settings), np.random.default_rng(seed))


def test_plain_looks_are_always_the_same():
    first, second = drawn_look(1), drawn_look(2)
    assert parts_that_differ(first, second) == {"luck"}  # of clutter, of which there is none
    assert first.clutter == 0


def test_varied_looks_depend_on_the_seed_alone():
    assert drawn_look(3, looks="varied") == drawn_look(3, looks="varied")
    drawn = [drawn_look(seed, looks="varied") for seed in range(60)]
    assert len({appearance.knob for appearance in drawn}) == 60
    assert {appearance.handle for appearance in drawn} == set(HANDLES)
    assert all(np.abs(appearance.camera).max() <= 0.03 and 0.7 < appearance.brightness < 1.3 for appearance in drawn)


COLOURS = {"wood", "knob", "bar", "floor"}
LIGHTS = {"light", "lamp_height", "brightness", "ambient"}
FACTORS = [
    ({"discs": False}, {"discs"}),
    ({"board": "bare"}, {"discs", "tracks"}),
    ({"labels": False}, {"labels"}),
    ({"handle_colours": "plain"}, {"bar", "pivot"}),
    ({"light": "side"}, LIGHTS),
    ({"light": "dim"}, LIGHTS),
    ({"colours": "second"}, COLOURS),
    ({"colours": "drawn"}, COLOURS),
    ({"viewpoint": "oblique"}, {"viewpoint"}),
    *(({"handle_shape": shape}, {"handle"}) for shape in ("ball", "square", "hollow")),
    ({"clutter": 5}, {"clutter"}),
    ({"looks": "varied"}, COLOURS | LIGHTS | {"grain", "handle", "camera"}),
]


def parts_that_differ(first, second):
    return {field.name for field in fields(first) if getattr(first, field.name) != getattr(second, field.name)}


@pytest.mark.parametrize("looks", ["plain", "varied"])
@pytest.mark.parametrize(("option", "parts"), FACTORS)
def test_a_factor_changes_its_part_alone_and_as_many_numbers_are_drawn_for_each(option, parts, looks):
    for seed in range(3):
        first, second = np.random.default_rng(seed), np.random.default_rng(seed)
        usual = appearance_of(SceneSettings(looks=looks), first)
        other = appearance_of(SceneSettings(**({"looks": looks} | option)), second)
        assert parts_that_differ(usual, other) <= parts
        assert parts_that_differ(usual, other) or looks == "varied"
        assert first.random() == second.random()


def test_drawn_colours_are_those_of_varied_looks():
    coloured, varied = drawn_look(4, colours="drawn"), drawn_look(4, looks="varied")
    assert not parts_that_differ(coloured, varied) & COLOURS
    assert coloured.knob != drawn_look(5, colours="drawn").knob


def test_handles_stand_out_from_their_bars_unless_they_are_plain():
    for seed in range(60):
        appearance = drawn_look(seed, looks="varied")
        assert np.abs(np.array(appearance.knob) - appearance.bar).max() > 0.25
        plain = drawn_look(seed, looks="varied", handle_colours="plain")
        assert plain.knob == plain.bar == plain.pivot
