"""The scenes of ``run looks`` before a camera of one's own: a person is told each of them and sets it up."""

import pytest
from lockprobe_robot.hardware import manual_camera
from lockprobe_robot.hardware.manual_scene import ManualScene
from plants.person import Person, handles_text

from lockprobe.boxes.families import box
from lockprobe.cli.run import run
from lockprobe.foundation.errors import BadValue
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

FIVE = box("random-5-3")
FACTORS = [*study("looks").conditions[-1].plant.options]


def test_every_scene_of_looks_is_told_before_its_trial_and_stands_in_its_record(tmp_path, monkeypatch):
    shots, people = tmp_path / "shots", []
    shots.mkdir()
    for viewpoint in ("", "-oblique"):
        (shots / f"handles{viewpoint}.toml").write_text(handles_text(FIVE), "utf-8")

    def person():
        people.append(Person(FIVE, folder=shots))
        return people[-1]

    monkeypatch.setattr(manual_camera, "TerminalOperator", person)
    asked = {"agent": ["viewer"], "box": "random-5-3", "trials": 1, "max_steps": 1}
    run("looks", plant="manual", camera=str(shots), out=tmp_path / "out", report=False, **asked)
    trials, said = load(tmp_path / "out"), [one.told[0] for one in people if one.told]
    assert len(trials) == len({*said}) == 16
    assert said[0] == "New trial of random-5-3. Set up the plain scene."
    for trial, line in zip(trials, said, strict=True):
        levels = {name: trial.plant[name] for name in FACTORS}
        assert line.endswith(ManualScene(**levels).instruction)
        assert (trial.plant["truth"], trial.ending, trial.error) == ("camera", "budget", None)
        assert trial.opening_pictures.keys() == trial.steps[0].pictures.keys() == {"rgb"}
    for name in FACTORS:
        assert sum(trial.plant[name] != ManualScene().levels[name] for trial in trials) == 8


def test_a_scene_has_the_names_and_the_plain_levels_of_the_simulated_one():
    ours, simulated = resolve_plant("manual?camera=x"), resolve_plant("fast-twin")
    assert ours.options == {name: simulated.options[name] for name in FACTORS}
    assert {*ours.doses} == {*FACTORS} & {*simulated.doses}


def test_all_of_a_scene_is_said_in_one_sentence():
    every = ManualScene(**dict.fromkeys(("discs", "labels"), False), handle_colours="plain", clutter=8, light="side",
                        colours="second", viewpoint="oblique", view_jitter=5.0)  # fmt: skip
    assert every.instruction == (
        "Set up the scene: no discs; handles in the colour of their bars; no labels; 8 small objects on and beside the "
        "board, at new places; light from a low lamp at the right; the second colours of board, handles and bars; "
        "camera at its place on the left side of the board; before every picture move the camera from its place by "
        "about 5 mm."
    )


@pytest.mark.parametrize("plant", ["manual", "symbolic"])
def test_looks_without_a_camera_are_refused_in_one_line(plant):
    expected = "one whose camera takes pictures: fast-twin, twin, or manual with --camera"
    with pytest.raises(BadValue, match=f"^plant: got '{plant}', expected {expected}$"):
        study("looks", plant=plant)
