"""``lockprobe rig calibrate``, as typed, on pictures of the twin."""

import json
from functools import partial

import numpy as np
import pytest
from calibration import tagged
from lockprobe_robot.box_model.tag_layout import board_checksum
from lockprobe_robot.calibration.calibration_file import calibration_for
from lockprobe_robot.calibration.pose import array_of
from lockprobe_robot.calibration.views import VIEWS_FILE
from typed import in_process

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.trial.pictures.png import to_png

ask = partial(in_process, "rig")


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Ten views of the tagged twin, in one of which a tag is left and in one of which the picture is black."""
    pytest.importorskip("cv2")
    from box_model.scenes import scene_of
    from calibration.tag_pictures import HandCamera, add_tag_prints, tag_bits

    from lockprobe.boxes.families import box

    folder, scene, (panel, tags) = tmp_path_factory.mktemp("views"), scene_of(box(tagged.BOX)), tagged.board()
    add_tag_prints(scene.spec, tags, tag_bits(range(4)))
    camera, rng, views = HandCamera(scene.spec), np.random.default_rng(2), []
    for number in range(12):
        pose, name = tagged.camera_pose(panel, rng), f"{number:02}.png"
        picture = camera.look(pose)
        if number == 3:
            picture[:] = 0
        if number == 7:
            picture[:, :320] = 90
        (folder / name).write_bytes(to_png(picture))
        views.append({"picture": name, "hand": (pose @ np.linalg.inv(tagged.eye())).tolist()})
    camera.close()
    facts = {"width": 640, "height": 480, "focal": [camera.focal] * 2, "centre": [319.5, 239.5]}
    (folder / VIEWS_FILE).write_text(json.dumps({"camera": facts, "views": views}))
    return folder


def test_a_calibration_finds_camera_and_board_and_names_what_it_refuses(pictures, tmp_path):
    done = ask("calibrate", pictures, "--box", tagged.BOX, "--out", tmp_path / "c.json")
    refused = done.stderr.splitlines()
    assert refused[0] == "refused 03.png: 0 of 4 tags seen (none); 3 are needed"
    assert refused[1].startswith("refused 07.png: ")
    assert len(refused) == 2
    for part in (
        "chain-2: 10 of 12 views used, 2 refused (park)",
        "hold-out error: ",
        "worst view",
        str(tmp_path / "c.json"),
    ):
        assert part in done.stdout
    panel, tags = tagged.board()
    found = calibration_for(tmp_path / "c.json", board=board_checksum(panel, tags))
    assert 1000 * np.linalg.norm((array_of(found.camera_in_hand) - tagged.eye())[:3, 3]) < 2.0
    assert 1000 * np.linalg.norm((array_of(found.board_in_base) - panel.pose)[:3, 3]) < 2.0
    assert found.errors.held_out_mm < 2.0


def test_a_wrong_size_of_tags_shows_in_the_errors(pictures, tmp_path):
    right = json.loads(ask("calibrate", pictures, "--box", tagged.BOX, "--out", tmp_path / "a.json", "--json").stdout)
    wrong = ask("calibrate", pictures, "--box", tagged.BOX, "--tag-size", 44, "--out", tmp_path / "b.json", "--json")
    facts = json.loads(wrong.stdout)
    assert facts["tag_mm"] == 44
    assert facts["board"] == right["board"]
    assert facts["errors"]["reprojection_px"] > 2 * right["errors"]["reprojection_px"]
    assert wrong.stderr.endswith("check --box, --tag-size, the numbers of the camera, and the place of every tag\n")


def test_poses_of_the_hand_in_millimetres_are_suspected(pictures, tmp_path):
    content = json.loads((pictures / VIEWS_FILE).read_text())
    for view in content["views"]:
        (tmp_path / view["picture"]).write_bytes((pictures / view["picture"]).read_bytes())
        for row in view["hand"][:3]:
            row[3] *= 1000
    (tmp_path / VIEWS_FILE).write_text(json.dumps(content))
    said = ask("calibrate", tmp_path, "--box", tagged.BOX).stderr.splitlines()
    assert said[-2:] == [
        "the arm tolerates 4 mm: a study refuses this calibration",
        "check the poses of the hand: metres, at the time of the picture",
    ]


@pytest.mark.parametrize(
    ("words", "mistake", "message"),
    [
        (["calibrate", "none"], BadFile, "views.json: cannot be read"),
        (["calibrate", "none", "--tag-size", "4"], BadValue, "millimetres from 10 to 200"),
    ],
)
def test_mistakes(words, mistake, message):
    with pytest.raises(mistake, match=message):
        ask(*words)


def test_a_picture_of_another_size_is_refused(pictures, tmp_path):
    content = json.loads((pictures / VIEWS_FILE).read_text())
    content["camera"]["width"] = 800
    (tmp_path / VIEWS_FILE).write_text(json.dumps(content))
    (tmp_path / "00.png").write_bytes((pictures / "00.png").read_bytes())
    with pytest.raises(BadFile, match=r"00\.png: 640 x 480 pixels; the camera has 800 x 480"):
        ask("calibrate", tmp_path, "--box", tagged.BOX)
