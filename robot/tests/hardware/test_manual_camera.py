"""A camera in front of a box that a person moves: what a picture shows is the truth."""

import numpy as np
import pytest
from lockprobe_robot.hardware import manual_camera
from lockprobe_robot.hardware.camera import FolderCamera
from lockprobe_robot.hardware.manual_camera import CameraSight
from lockprobe_robot.hardware.manual_scene import ManualScene
from lockprobe_robot.hardware.position_reader import read_handles
from plants.person import Person, handles_text

from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault, UserMistake
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plants.manual import Manual
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import check_plant

FIVE = box("random-5-3")
LABELS = ("C", "A", "E", "D", "B")


def plant_with(person, **parts):
    return Manual(person.box, labels=LABELS[: len(person.box.joints)], operator=person, **parts)


def camera_in(folder):
    (folder / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    return {"sight": CameraSight(FolderCamera(folder), read_handles(folder / "handles.toml", FIVE))}


def test_a_camera_in_front_of_the_person_is_a_plant_too(tmp_path):
    def made(box, labels, rng):
        return Manual(box, labels=labels, operator=Person(box, folder=tmp_path), **camera_in(tmp_path))

    check_plant(made, boxes=[FIVE], attempts=5)


def test_a_wrong_start_and_a_picture_that_shows_nothing_are_said_and_asked_again(tmp_path):
    person = Person(FIVE, folder=tmp_path)
    plant = plant_with(person, **camera_in(tmp_path))
    first = tuple(not at for at in FIVE.initial)
    states, take = iter([first, None]), person.photograph

    def photograph():
        state = next(states, FIVE.initial)
        person.now = state or FIVE.initial
        if state is None:
            (tmp_path / "999.png").write_bytes(b"half a pict")
            return
        (tmp_path / "999.png").unlink(missing_ok=True)
        take()

    person.photograph = photograph
    assert plant.observe().configuration == FIVE.initial
    assert [line.partition(":")[0].partition(" ")[0] for line in person.told[1:]] == [
        "Set",
        "The",
        f"{tmp_path}/999.png",
    ]
    assert person.told[2].count(" at ") == 5
    assert person.told[3].endswith("is no whole PNG or JPEG picture.")


def test_what_a_picture_shows_is_said(tmp_path):
    person = Person(FIVE, folder=tmp_path)
    plant = plant_with(person, **camera_in(tmp_path))
    plant.observe()
    after = plant.attempt(0).configuration
    did = "moved" if after[0] else "did not move"
    assert person.told[-1] == f"The picture shows {bits(after)}: C ({FIVE.names[0]}) {did}."


def test_another_joint_that_moves_with_it_breaks_the_trial(tmp_path):
    plant = plant_with(Person(FIVE, folder=tmp_path, clumsy=True), **camera_in(tmp_path))
    plant.observe()
    with pytest.raises(PlantFault, match=r"^C \(.*\) was attempted and A \(.*\) moved: 00000 became .1000$"):
        plant.attempt(0)


def test_agents_see_the_picture_that_was_taken(tmp_path):
    plant = plant_with(Person(FIVE, folder=tmp_path), **camera_in(tmp_path))
    frame = plant.observe().look()
    places = frame.camera.project(frame.handles)[..., :2]
    assert np.allclose(places, read_handles(tmp_path / "handles.toml", FIVE).places)
    assert np.array_equal(frame.rgb, np.asarray(__import__("PIL.Image").Image.open(tmp_path / "000.png")))


def test_a_trial_with_pictures_is_played_to_its_end(tmp_path, monkeypatch):
    """By pictures in a folder, through the viewer's eyes on both sides: those of the plant and those of the agent."""
    (tmp_path / "handles.toml").write_text(handles_text(FIVE), "utf-8")
    monkeypatch.setattr(manual_camera, "TerminalOperator", lambda: Person(FIVE, folder=tmp_path))
    spec = f"manual?camera={tmp_path}"
    by_hand = run_trial(agent="viewer?acuity=64", box="random-5-3", plant=spec, modality="rgb", seed=2, shuffle="never")
    by_rules = run_trial(agent="human-inspired", box="random-5-3", seed=2, shuffle="never")
    assert by_hand.ending == by_rules.ending == "solved"
    assert by_hand.actions == by_rules.actions
    assert by_hand.plant == {"plant": spec, "truth": "camera", "camera": "folder", **ManualScene().levels}


def test_pictures_of_painted_labels_are_refused_with_shuffled_ones(tmp_path):
    """Agents are told that the label of each joint is painted next to it."""
    with pytest.raises(BadValue, match="^shuffle: got 'trial', expected never with pictures of a real box"):
        run_trial(agent="viewer", plant=f"manual?camera={tmp_path}", modality="rgb")


@pytest.mark.parametrize(
    ("spec", "error", "message"),
    [
        ("manual?camera=/nowhere", BadFile, "/nowhere/handles.toml"),
        ("manual?handles=h.toml", BadValue, "handles: got 'h.toml', expected camera=FOLDER"),
        ("manual?lens=2", UserMistake, "no option of manual is called 'lens'"),
        ("manual?light=side", BadValue, "light: got 'side', expected camera=FOLDER"),
        ("manual?camera=x&colours=drawn", BadValue, "colours: got 'drawn', expected one of plain, second"),
        ("manual?camera=x&view_jitter=60", BadValue, "view_jitter: got 60.0, expected a number from 0 to 50"),
        ("manual?camera=x&viewpoint=oblique", BadFile, "x/handles-oblique.toml: no such file"),
    ],
)
def test_a_wrong_camera_is_refused_in_one_line(spec, error, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error) as caught:
        resolve_plant(spec).check(box("chain-4"))
    assert str(caught.value).startswith(message)
