"""A camera in front of a box: positions are read rightly or not at all, and what a picture shows is the truth."""

import itertools

import numpy as np
import pytest
from drawn_board import HANDLES, board
from hardware.fakes import image_handles
from lockprobe_robot.hardware.sight import CameraSight, FolderCamera, Shot, read_handles
from PIL import Image
from plants.person import Person, handles_text

from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe.plants.manual import Manual
from lockprobe.testing import check_plant

FIVE = box("random-5-3")
LABELS = ("C", "A", "E", "D", "B")
RED = np.full((40, 60, 3), (200, 20, 10), dtype=np.uint8)


class Camera:
    def __init__(self, shot):
        self.grab = lambda: shot


def read(rgb, depth=None):
    return CameraSight(Camera(Shot(rgb=rgb, depth=depth)), image_handles(FIVE)).read(FIVE.names)


def test_every_configuration_is_read_and_agents_see_the_picture():
    for seed, positions in enumerate(list(itertools.product((False, True), repeat=5))[::8]):
        seen = read(picture := board(positions, seed))
        assert seen.configuration == positions
        frame = seen.look()
        assert frame.rgb is picture
        assert frame.camera.project(frame.handles)[..., :2] == pytest.approx(np.array(HANDLES))


def test_what_is_unclear_or_of_another_shape_is_a_fault_that_says_so():
    picture = board((0,) * 5)
    (column, top), (_, bottom) = HANDLES[2]
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
    for place in (top, bottom):
        picture[(x - column) ** 2 + (y - place) ** 2 < 20**2] = 128
    for rgb, depth, why in (
        (picture, None, f"where {FIVE.names[2]} stands"),
        (RED, None, r"\(40, 60, 3\) of uint8, expected \(240, 320, 3\)"),
        (picture.astype(float), None, "of float64"),
        (picture, np.zeros((4, 4), np.float32), r"depth of \(4, 4\)"),
    ):
        with pytest.raises(PlantFault, match=why):
            read(rgb, depth)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("width = 320", "width = 32"), "width: expected at least 64"),
        (("at_1 = [40.0, 140.0]", ""), "at_1: is missing"),
        (("at_1 = [40.0, 140.0]", "at_1 = [40, 240]"), "a place outside 320 x 240 pixels"),
        (("at_1 = [40.0, 140.0]", "at_1 = [41, 91]"), "at_0 and at_1 are nearer than 8 pixels"),
        (("height = 240", "height = 240\n[lid]\n"), "got the joints lid, "),
    ],
)
def test_a_wrong_file_of_handles_is_refused_in_one_line(tmp_path, change, why):
    path = tmp_path / "handles.toml"
    path.write_text(handles_text(FIVE))
    assert [(one.at_0, one.at_1) for one in read_handles(path, FIVE).joints.values()] == list(HANDLES)
    path.write_text(handles_text(FIVE).replace(*change))
    with pytest.raises(BadFile) as caught:
        read_handles(path, FIVE)
    assert why in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_picture_of_a_folder_is_used_once_upright_and_only_whole(tmp_path):
    Image.fromarray(RED).save(tmp_path / "old.png")
    camera = FolderCamera(tmp_path)
    with pytest.raises(PlantFault, match="there is no new picture"):
        camera.grab()
    Image.fromarray(RED).save(tmp_path / "a.png")
    whole = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(whole[:60])
    with pytest.raises(PlantFault, match="no whole PNG or JPEG picture"):
        camera.grab()
    (tmp_path / "a.png").write_bytes(whole)
    assert np.array_equal(camera.grab().rgb, RED)
    with pytest.raises(PlantFault, match="there is no new picture"):
        camera.grab()
    exif = Image.Exif()
    exif[0x0112] = 6  # held upright
    Image.fromarray(RED).save(tmp_path / "phone.JPG", exif=exif)
    assert camera.grab().rgb.shape == (60, 40, 3)
    with pytest.raises(BadFile, match="no such folder"):
        FolderCamera(tmp_path / "none")


def by_hand(person):
    folder = person.folder
    (folder / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    sight = CameraSight(FolderCamera(folder), read_handles(folder / "handles.toml", FIVE))
    return Manual(FIVE, labels=LABELS, operator=person, sight=sight)


def test_a_camera_in_front_of_the_person_is_a_plant_too(tmp_path):
    check_plant(lambda box, labels, rng: by_hand(Person(box, folder=tmp_path)), boxes=[FIVE], attempts=5)


def test_a_wrong_start_and_a_picture_that_shows_nothing_are_said_and_asked_again(tmp_path):
    person = Person(FIVE, folder=tmp_path)
    plant, states, take = by_hand(person), iter([tuple(not at for at in FIVE.initial), None]), person.photograph

    def photograph():
        state = next(states, FIVE.initial)
        person.now = state or FIVE.initial
        (tmp_path / "999.png").unlink(missing_ok=True)
        if state is None:
            (tmp_path / "999.png").write_bytes(b"half a pict")
        else:
            take()

    person.photograph = photograph
    assert plant.observe().configuration == FIVE.initial
    assert person.told[1].count(" at ") == 5
    assert person.told[2].endswith("no whole PNG or JPEG picture.")
    after = plant.attempt(0).configuration
    did = "moved" if after[0] else "did not move"
    assert person.told[-1] == f"The picture shows {bits(after)}: C ({FIVE.names[0]}) {did}."
