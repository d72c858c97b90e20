"""The Menagerie's meshes are found without the network, are shown, and change no physics."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.arm.hand import add_hand
from lockprobe_robot.arm.panda import HOME, add_panda
from lockprobe_robot.arm.skin import find_skin, wear_skin
from lockprobe_robot.geom_groups import HIDDEN

CUBE = "\n".join(
    [f"v {x} {y} {z}" for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
    + ["f 1 3 4", "f 1 4 2", "f 5 6 8", "f 5 8 7", "f 1 2 6", "f 1 6 5", "f 3 7 8", "f 3 8 4", "f 1 5 7", "f 1 7 3"]
    + ["f 2 4 8", "f 2 8 6"]
)
PANDA = """
<mujoco><compiler meshdir="assets" angle="radian"/>
<default><default class="visual"><geom type="mesh" contype="0" conaffinity="0" group="2"/></default></default>
<asset><material name="black" rgba="0.25 0.5 0.25 1"/><mesh file="link5_0.obj"/><mesh name="c" file="link5_0.obj"/></asset>
<worldbody>%s</worldbody></mujoco>
"""


@pytest.fixture
def checkout(tmp_path):
    """A description of the arm with one mesh, on the fifth link."""
    folder = tmp_path / "franka_emika_panda"
    (folder / "assets").mkdir(parents=True)
    (folder / "assets" / "link5_0.obj").write_text(CUBE)
    bodies = ""
    for number in reversed(range(8)):
        shapes = (
            '<geom class="visual" mesh="link5_0" material="black"/><geom type="mesh" mesh="c"/>' if number == 5 else ""
        )
        bodies = f'<body name="link{number}">{shapes}{bodies}</body>'
    (folder / "panda.xml").write_text(PANDA % bodies)
    return tmp_path


def arm(description=None):
    spec = mujoco.MjSpec()
    add_hand(spec, add_panda(spec))
    if description is not None:
        wear_skin(spec, description)
    return spec.compile()


def test_a_checkout_is_found_by_its_variable(checkout):
    assert find_skin({"MENAGERIE_ROOT": str(checkout)}) == checkout / "franka_emika_panda" / "panda.xml"


def test_what_the_package_has_stored_whole_is_found(checkout):
    stored = checkout / "cache" / "models" / "franka_emika_panda-0123456789abcdef"
    stored.parent.mkdir(parents=True)
    (checkout / "franka_emika_panda").rename(stored)
    variables = {"MENAGERIE_CACHE_DIR": str(checkout / "cache")}
    assert find_skin(variables) is None
    (stored / ".complete").touch()
    assert find_skin(variables) == stored / "panda.xml"


def test_where_there_is_none_none_is_found(tmp_path):
    assert find_skin({"MENAGERIE_ROOT": str(tmp_path)}) is None
    assert find_skin({"HOME": str(tmp_path), "LOCALAPPDATA": str(tmp_path)}) is None


def test_the_meshes_are_seen_in_place_of_the_shapes_that_they_cover(checkout):
    model = arm(find_skin({"MENAGERIE_ROOT": str(checkout)}))
    on_link = [i for i in range(model.ngeom) if model.geom_bodyid[i] == model.body("link5").id]
    meshes = [i for i in on_link if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH]
    assert len(meshes) == 1
    assert np.allclose(model.geom_rgba[meshes[0]], (0.25, 0.5, 0.25, 1))
    assert all(model.geom_group[i] == HIDDEN for i in on_link if i not in meshes)
    others = [i for i in range(model.ngeom) if i not in on_link]
    assert not (model.geom_group[others] == HIDDEN).any()


def test_it_changes_no_physics(checkout):
    motions = []
    for description in (None, find_skin({"MENAGERIE_ROOT": str(checkout)})):
        model = arm(description)
        data = mujoco.MjData(model)
        data.qpos[:7] = HOME
        for _ in range(200):
            mujoco.mj_step(model, data)
        motions.append((data.qpos.copy(), data.sensordata.copy()))
    assert np.array_equal(motions[0][0], motions[1][0])
    assert np.array_equal(motions[0][1], motions[1][1])
