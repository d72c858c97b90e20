"""A camera in front of a box: positions are read rightly or not at all, and what a picture shows is the truth."""

import itertools
import re
import runpy
import threading
from pathlib import Path
from queue import Queue
from types import SimpleNamespace

import numpy as np
import pytest
from drawn_board import HANDLES, board
from hardware.fakes import image_handles
from lockprobe_robot import plants
from lockprobe_robot.hardware.sight import CameraSight, FolderCamera, Photographed, Shot, read_handles
from PIL import Image
from plants.person import Person, handles_text
from typed import in_process

from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plants.manual import ENTER
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import check_plant

FIVE = box("random-5-3")
LABELS = ("C", "A", "E", "D", "B")
RED = np.full((40, 60, 3), (200, 20, 10), dtype=np.uint8)


def read(rgb, depth=None):
    camera = SimpleNamespace(grab=lambda: Shot(rgb=rgb, depth=depth))
    return CameraSight(camera, image_handles(FIVE)).read(FIVE.names)


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
        (("width = 320", "width = 32"), "width: got 32, expected at least 64"),
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
    return Photographed(FIVE, labels=LABELS, operator=person, sight=sight)


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


def test_a_folder_whose_name_has_to_be_encoded_is_a_plant_and_its_panel_is_never_shuffled(tmp_path, monkeypatch):
    (made := tmp_path / "A&B 100%+").mkdir()
    (made / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    monkeypatch.setattr(plants, "TerminalOperator", lambda: Person(FIVE, folder=made))
    asked = {"agent": "viewer", "box": FIVE.name, "modality": "rgb"}
    asked |= {"plant": f"manual?camera={tmp_path}/A%26B 100%25%2B"}
    resolve_plant(study("flips", shuffle="never", **asked).plant).check(FIVE)
    with pytest.raises(BadValue, match="^shuffle: got 'trial', expected never with pictures of a real box"):
        study("flips", shuffle="trial", **asked)


def test_a_folder_without_places_of_handles_is_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadFile, match="^shots/handles.toml: no such file; it says where pictures show the handles.*$"):
        in_process("run", "flips", "--agent", "random", "--plant", "manual?camera=shots")
    assert list(tmp_path.iterdir()) == []


EXAMPLE = Path(__file__).parents[3] / "examples" / "twin_camera.py"
NAMED = re.compile(r"Move joint \w \(([\w-]+)\)")


class Rehearsing:
    """Answers Lockprobe, after typing into the example the joint that Lockprobe names."""

    def __init__(self, type_in):
        self.type_in = type_in

    def ask(self, question, answers):
        assert answers == (ENTER,)
        named = NAMED.search(question)
        self.type_in(named[1] if named else "")
        return ENTER

    def tell(self, line):
        assert line.startswith(("New trial of chain-4.", "The picture shows "))


def test_a_rehearsal_is_played_on_the_twins_pictures_that_the_example_takes(tmp_path, monkeypatch):
    photograph = runpy.run_path(str(EXAMPLE))["photograph"]
    typed, taken = Queue(), Queue()

    def ask(question):
        taken.put(question)
        return typed.get(timeout=60)

    camera = threading.Thread(target=photograph, args=(tmp_path, box("chain-4"), ask), daemon=True)
    camera.start()
    taken.get(timeout=60)

    def type_in(words):
        typed.put(words)
        taken.get(timeout=60)

    monkeypatch.setattr(plants, "TerminalOperator", lambda: Rehearsing(type_in))
    short = {"agent": "human-inspired", "seed": 2, "max_steps": 2}
    by_hand = run_trial(plant=f"manual?camera={tmp_path}", **short)
    by_rules = run_trial(**short)
    typed.put("q")
    camera.join(timeout=60)
    assert not camera.is_alive()
    assert [(step.joint, step.moved) for step in by_hand.steps] == [(step.joint, step.moved) for step in by_rules.steps]
    assert {step.sensed["truth"] for step in by_hand.steps} == {"camera"}
