"""What others rely on in a scene: names, places, what touches what."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest
from plants.scene.scenes import mechanism_of, scene_of

from lockprobe.errors import BadValue
from lockprobe.lockbox.families import box
from lockprobe.plants.layers import HIDDEN, PANEL
from lockprobe.plants.scene.board import TIMESTEP, compile_scene
from lockprobe.plants.settings import SceneSettings


def test_knobs_are_where_the_panel_says_they_are():
    for name, tilt in (("chain-4", 20), ("branched", 45)):
        mechanism, model, data = mechanism_of(box(name), tilt=tilt)
        panel = scene_of(box(name), tilt=tilt).panel
        for position in (False, True):
            mechanism.set_configuration((position,) * len(panel.fittings))
            for i in range(len(panel.fittings)):
                expected = panel.pose[:3, :3] @ panel.handles[i, int(position)] + panel.pose[:3, 3]
                assert data.site(f"knob-{i}").xpos == pytest.approx(expected, abs=1e-6)
                assert model.joint(f"joint-{i}").range == pytest.approx([0, panel.fittings[i].travel])


def test_the_scene_itself_touches_nothing_but_what_locks():
    _, model, _ = mechanism_of(box("chain-4"))
    assert model.opt.timestep == TIMESTEP <= 0.002
    pairs = {
        model.geom(g).name.split("-")[0] for pair in zip(model.pair_geom1, model.pair_geom2, strict=True) for g in pair
    }
    assert pairs == {"pin", "block"}
    for first in range(model.ngeom):
        for second in range(model.ngeom):
            assert not model.geom_contype[first] & model.geom_conaffinity[second]
    assert all(model.geom_contype[model.geom(name).id] == PANEL for name in ("board", "knob-0", "ground"))


def test_all_that_locks_is_behind_the_board_and_unseen():
    for name in ("chain-4", "common-cause-4", "gray-code-8"):
        scene = scene_of(box(name))
        model = scene.spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        for i in range(model.ngeom):
            if model.geom(i).name.split("-")[0] in {"pin", "block", "lifter", "crossbar"}:
                assert model.geom_group[i] == HIDDEN
                inside = scene.panel.pose[:3, :3].T @ (data.geom_xpos[i] - scene.panel.pose[:3, 3])
                assert -scene.panel.depth < inside[2] < -0.01


def test_looks_change_nothing_that_can_be_touched():
    plain, varied = (scene_of(box("chain-4"), seed=5, looks=looks).spec.compile() for looks in ("plain", "varied"))
    for what in ("body_mass", "body_inertia", "dof_armature", "dof_damping", "dof_frictionloss", "jnt_range"):
        assert (getattr(plain, what) == getattr(varied, what)).all(), what
    hands_on = [model.geom_size[model.geom_contype != 0] for model in (plain, varied)]
    assert (hands_on[0] == hands_on[1]).all()
    assert (plain.tex_data[:3000] != varied.tex_data[:3000]).any()


def test_the_same_seed_gives_the_same_model():
    first, second, other = (scene_of(box("random-5-1"), seed=seed, looks="varied").spec.compile() for seed in (7, 7, 8))
    for what in ("body_pos", "geom_size", "geom_pos", "geom_rgba", "cam_pos", "light_pos", "eq_data", "tex_data"):
        assert (getattr(first, what) == getattr(second, what)).all(), what
    assert (first.tex_data != other.tex_data).any()


def test_friction_is_a_multiple_of_the_usual():
    once, thrice = (scene_of(box("chain-4"), friction=friction).spec.compile() for friction in (1.0, 3.0))
    joints = [once.joint(f"joint-{i}").dofadr[0] for i in range(4)]
    assert thrice.dof_frictionloss[joints] == pytest.approx(3 * once.dof_frictionloss[joints])


def test_labels_have_to_fit_the_joints():
    with pytest.raises(BadValue, match="labels.*one for each of 4 joints"):
        compile_scene(box(), labels=("A",), settings=SceneSettings(), rng=np.random.default_rng(1))


def test_a_scene_is_made_without_any_graphics():
    code = (
        "import sys, numpy, lockprobe.plants.scene.board as board, lockprobe.plants.settings as s, lockprobe;"
        "board.compile_scene(lockprobe.box(), labels=tuple('ABCD'), settings=s.SceneSettings(),"
        " rng=numpy.random.default_rng(1)).spec.compile();"
        "print([m for m in sys.modules if m.startswith(('OpenGL', 'mujoco.egl', 'mujoco.osmesa'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
