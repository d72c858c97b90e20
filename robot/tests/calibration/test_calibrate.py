"""Camera and board are found from pictures with known poses; what cannot be relied on is refused; errors are honest."""

import json
import math
import shutil
from functools import cache, partial

import lockprobe_robot.calibration.calibrate as library
import mujoco
import numpy as np
import pytest
from box_model.scenes import scene_of
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import QUIET_ZONE, TAG_SIDE, place_tags
from lockprobe_robot.calibration.calibrate import BoardView, solved
from lockprobe_robot.calibration.calibration_file import VIEWS_FILE, Calibration, array_of, pose_of
from lockprobe_robot.geom_groups import NOTHING
from lockprobe_robot.renderer import Renderer
from scipy.spatial.transform import Rotation
from typed import in_process

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.trial.pictures.frame import to_png

cv2 = pytest.importorskip("cv2")

BOX = "chain-2"
PANEL = lay_out_panel(box(BOX))
ask = partial(in_process, "rig", "calibrate")


@cache
def eye():
    """Camera in hand."""
    turn = Rotation.from_euler("zyx", [80, -8, 5], degrees=True).as_matrix()
    return pose_of(turn, np.array((0.055, -0.032, 0.041)))


def camera_pose(rng):
    angles = np.radians([25.0, 25.0, 45.0]) * rng.uniform(-1, 1, 3)
    turn = (Rotation.from_euler("x", np.pi) * Rotation.from_euler("xyz", angles)).as_matrix()
    return PANEL.pose @ pose_of(turn, (*rng.uniform(-0.02, 0.02, 2), 0) - rng.uniform(0.4, 0.5) * turn[:, 2])


def views(count, millimetres=0.0):
    """Views of a board, all poses known; the hand's positions have noise."""
    rng, found = np.random.default_rng(1), []
    for number in range(count):
        pose = camera_pose(rng)
        hand = pose @ np.linalg.inv(eye())
        hand[:3, 3] += 1e-3 * millimetres * rng.standard_normal(3)
        board = np.linalg.inv(pose) @ PANEL.pose
        found.append(BoardView(picture=f"{number}.png", hand=hand, board=board, reprojection=0.1))
    return found


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Twelve views of the tagged twin, one of which is black, and one shows too few tags.

    Each tag is a mesh with texture coordinates: a face of a MuJoCo box does not show a picture as it was drawn.
    """
    folder, spec, rng = tmp_path_factory.mktemp("views"), scene_of(box(BOX)).spec, np.random.default_rng(2)
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    square = (0.5 + QUIET_ZONE) * TAG_SIDE * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
    for number, middle in enumerate(place_tags(PANEL)):
        cells = np.pad(cv2.aruco.generateImageMarker(family, number, 8) > 0, 1, constant_values=True)
        name, grey = f"tag-{number}", np.kron(cells, np.full((32, 32), 235)).astype(np.uint8)
        texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=320, height=320, nchannel=3)
        texture.data = np.repeat(grey[..., None], 3, axis=-1).tobytes()
        spec.add_material(name=name, specular=0.0, shininess=0.0).textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        spec.add_mesh(
            name=name,
            uservert=square.ravel(),
            userface=[0, 3, 2, 0, 2, 1],
            usertexcoord=[0, 0, 1, 0, 1, 1, 0, 1],
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        spec.body("panel").add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            material=name,
            pos=[*middle, 0.0001],
            mass=0.0,
            contype=NOTHING,
            conaffinity=NOTHING,
        )
    spec.worldbody.add_body(name="hand", mocap=True).add_camera(name="hand", fovy=58.0)
    model = spec.compile()
    data, renderer, said = mujoco.MjData(model), Renderer(model, width=640, height=480), []
    for number in range(12):
        pose, name = camera_pose(rng), f"{number:02}.png"
        data.mocap_pos[0] = pose[:3, 3]
        mujoco.mju_mat2Quat(data.mocap_quat[0], np.ascontiguousarray(pose[:3, :3] @ np.diag([1.0, -1, -1])).ravel())
        renderer.pose(data)
        picture = renderer.colours("hand")
        if number == 3:
            picture[:] = 0
        if number == 7:
            picture[:, :320] = 90
        (folder / name).write_bytes(to_png(picture))
        said.append({"picture": name, "hand": (pose @ np.linalg.inv(eye())).tolist()})
    renderer.close()
    focal = 240 / math.tan(math.radians(29))
    facts = {"width": 640, "height": 480, "focal": [focal] * 2, "centre": [319.5, 239.5]}
    (folder / VIEWS_FILE).write_text(json.dumps({"camera": facts, "views": said}))
    return folder


def test_a_calibration_finds_camera_and_board_and_names_what_it_refuses(pictures, tmp_path):
    done = ask(pictures, "--box", BOX, "--out", tmp_path / "c.json")
    refused = done.stderr.splitlines()
    assert refused[0] == "refused 03.png: 0 of 4 tags seen (none); 3 are needed"
    assert refused[1].startswith("refused 07.png: ")
    assert len(refused) == 2
    for part in ("chain-2: 10 of 12 views used", "hold-out error: ", "worst view", str(tmp_path / "c.json")):
        assert part in done.stdout
    found = Calibration.model_validate_json((tmp_path / "c.json").read_text())
    assert 1000 * np.linalg.norm((array_of(found.camera_in_hand) - eye())[:3, 3]) < 2.0
    assert 1000 * np.linalg.norm((array_of(found.board_in_base) - PANEL.pose)[:3, 3]) < 2.0
    assert found.held_out_mm < 2.0
    wrong = ask(pictures, "--box", BOX, "--tag-size", 44, "--out", tmp_path / "b.json", "--json")
    assert json.loads(wrong.stdout)["reprojection_px"] > 2 * found.reprojection_px
    assert "\na study accepts 4 mm and tags within 1 pixel: check --box, --tag-size, " in wrong.stderr


def still(content):
    for view in content["views"]:
        view["hand"] = np.eye(4).tolist()


MISTAKES = {
    "another size": (lambda content: content["camera"].update(width=800), "640 x 480 pixels; the camera has 800 x 480"),
    "few views": (lambda content: content.update(views=content["views"][:5]), "views with the board: got 4, expected"),
    "no rotation": (still, "rotation of the hand off its most frequent axis.*turn the hand about two axes"),
    "another folder": (lambda content: content["views"][0].update(picture="../00.png"), "views.0.picture: "),
    "not rigid": (lambda content: content["views"][0].update(hand=[[1, 0, 0, 0]] * 4), "expected four rows of a rigid"),
    "lens": (lambda content: content["camera"].update(distortion=[0, 0, 0]), "3 numbers; expected none, 4, 5 or 8"),
    "no picture": (lambda content: content["views"][0].update(picture="gone.png"), "gone.png: cannot be read"),
}


@pytest.mark.parametrize(("change", "message"), MISTAKES.values(), ids=MISTAKES)
def test_what_is_wrong_is_said_in_one_line(pictures, tmp_path, change, message):
    content = json.loads((pictures / VIEWS_FILE).read_text())
    change(content)
    shutil.copytree(pictures, tmp_path / "views")
    (tmp_path / "views" / VIEWS_FILE).write_text(json.dumps(content))
    with pytest.raises((BadFile, BadValue), match=message) as caught:
        ask(tmp_path / "views", "--box", BOX)
    assert "\n" not in str(caught.value)


def test_the_hold_out_error_grows_with_the_noise_and_is_no_smaller_than_the_error_of_the_board():
    tags, held, off = place_tags(PANEL), [], []
    for millimetres in (0.0, 0.5, 2.0, 8.0):
        seen = views(16, millimetres=millimetres)
        camera, board = solved(seen)
        held.append(np.mean(library._held_out(seen, tags)))
        off.append(1000 * np.linalg.norm((board - PANEL.pose)[:3, 3]))
        if not millimetres:
            assert camera == pytest.approx(eye(), abs=1e-6)
            assert board == pytest.approx(PANEL.pose, abs=1e-6)
    assert held[0] < 0.01 < held[1] < held[2] < held[3]
    assert (np.array(held) >= off).all()
    seen = views(16)
    seen[5].hand[:3, 3] += (0.03, 0, 0)
    assert max(library._held_out(seen, tags)) > 20, "a single wrong view shows in the worst error"
