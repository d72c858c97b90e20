"""Pictures: depth is metric, only what is shown is seen, looking changes nothing, noise and view are luck times a size."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest
from drawn_board import heights_at
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.plants import renderer
from lockprobe_robot.simulated_plant import add_depth_noise
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import PlantFault


def test_a_machine_that_cannot_draw_is_told_so_in_one_line():
    program = """
import lockprobe
from lockprobe_robot.plants import renderer
try:
    renderer()
except lockprobe.foundation.errors.UserMistake as mistake:
    print(mistake)
"""
    words = [sys.executable, "-W", "ignore", "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, env=os.environ | {"PATH": "", "MUJOCO_GL": "off"})
    assert re.match(r"pictures need OpenGL, which does not work here \(.*: install libEGL", done.stdout), done.stderr
    assert done.stdout.count("\n") == 1


def test_a_process_that_was_forked_after_a_look_is_refused_instead_of_hanging():
    program = """
import os, mujoco
from lockprobe_robot.renderer import renderer_name
from lockprobe.foundation.errors import BadValue
renderer_name()
if (child := os.fork()) == 0:
    renderer_name.cache_clear()
    try:
        renderer_name()
    except BadValue:
        os._exit(3)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, timeout=120)
    assert done.stdout == "3\n"


def test_importing_and_naming_plants_touches_neither_mujoco_nor_graphics():
    modules = ["lockprobe", "lockprobe.cli", "lockprobe.interventions.camera", "lockprobe.plants.catalogue as plants"]
    program = "; ".join(f"import {one}" for one in modules)
    program += "; [plants.resolve_plant(name) for name in plants.PLANTS]"
    program += "; import sys; print([name for name in ('mujoco', 'OpenGL', 'glfw') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def plant(**settings):
    settings = SceneSettings(width=160, height=120, **settings)
    return FastTwin(box("chain-4"), labels=tuple("ABCD"), settings=settings, rng=np.random.default_rng(1))


def test_a_moment_can_be_looked_at_until_it_ends_and_a_look_that_is_refused_takes_no_luck():
    seen, other = plant(depth_noise=0.002), plant(depth_noise=0.002)
    late, first = seen.observe().look, [one.attempt(3).look for one in (seen, other)]
    with pytest.raises(PlantFault, match="after the next attempt"):
        late()
    frames = [look() for look in first]
    assert frames[0].depth.tobytes() == frames[1].depth.tobytes()
    assert frames[0].rgb.tobytes() == frames[1].rgb.tobytes()
    assert seen.facts["renderer"] == renderer()


def test_the_view_moves_with_every_picture_and_the_recorded_camera_and_the_noise_of_depth_do_not():
    nominal = plant(depth_noise=0.002).observe().look()
    look = plant(depth_noise=0.002, view_jitter=5.0).observe().look
    frames = [look(), look()]
    assert (frames[0].rgb != nominal.rgb).any()
    assert (frames[0].rgb != frames[1].rgb).any()
    for frame in frames:
        assert (frame.camera.panel == nominal.camera.panel).all()
        board = np.abs(heights_at(nominal.camera, frame.depth)[40:80, 40:120])
        assert np.median(board) < 0.06, "it is still the board, not far away"


FLAT = np.full((120, 160), 0.7, np.float32)


def sensed(depth, noise):
    return add_depth_noise(depth.astype(np.float32), noise, np.random.default_rng(1))


def test_depth_is_rounded_its_noise_is_as_stated_and_the_same_luck_enlarged_and_its_holes_are_along_edges():
    depth = np.linspace(0.5, 0.9, 500, dtype=np.float32).reshape(20, 25)
    assert np.abs(sensed(depth, 0.0) - depth).max() <= 0.000501
    assert np.std(sensed(FLAT, 0.004)) == pytest.approx(0.004, rel=0.03)
    assert np.std(sensed(2 * FLAT, 0.004)) == pytest.approx(0.016, rel=0.03)
    small, large = (sensed(FLAT, noise) - 0.7 for noise in (0.004, 0.008))
    assert np.abs(large - 2 * small).max() < 0.0016
    streams = [np.random.default_rng(3) for _ in range(2)]
    for noise, rng in zip((0.0, 0.05), streams, strict=True):
        add_depth_noise(FLAT, noise, rng)
    assert streams[0].random() == streams[1].random()
    depth = FLAT.copy()
    depth[:, 80:] = 0.8
    lost = sensed(depth, 0.001) == 0
    assert lost[:, 79:81].mean() == pytest.approx(0.6, abs=0.1)
    assert not lost[:, :79].any()
    depth[:60] = 0
    assert not sensed(depth, 0.01)[:59].any()
