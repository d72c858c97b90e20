"""``lockprobe run --camera``: the camera of the plant ``manual``, as an option of the command line."""

import pytest
from lockprobe_robot.hardware import sight
from plants.person import Person, handles_text
from typed import typed

from lockprobe.boxes.families import box
from lockprobe.cli.run import run
from lockprobe.foundation.errors import BadValue
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

FIVE = "random-5-3"
PLAYED = {"agent": ["viewer?acuity=64"], "box": FIVE, "p": "0", "trials": 1, "repetitions": 1}
PLAYED |= {"modality": ["rgb"], "shuffle": "never"}  # by pictures on both sides: those of the plant and of the agent


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with pictures whose name has to be encoded in a spec, next to a person."""
    made = tmp_path / "A&B 100%+"
    made.mkdir()
    (made / "handles.toml").write_text(handles_text(box(FIVE)), "utf-8")
    monkeypatch.setattr(sight, "TerminalOperator", lambda: Person(box(FIVE), folder=made))
    return made


def test_a_folder_is_played_and_the_study_is_that_of_the_spec(folder, tmp_path):
    plant, out, spelled = "manual", tmp_path / "s", f"manual?camera={tmp_path}/A%26B 100%25%2B"
    run("flips", plant=plant, camera=str(folder), out=out, report=False, **PLAYED)
    (trial,) = load(out)
    assert (trial.ending, trial.plant["truth"], trial.plant["plant"]) == ("solved", "camera", spelled)
    assert read_study(out).identity == study("flips", **{**PLAYED, "p": [0.0]}, plant=spelled).identity
    run("flips", plant=spelled, out=out, report=False, **PLAYED)  # the same command, spelled otherwise
    run("flips", plant=spelled, camera=str(folder), out=out, report=False, **PLAYED)
    assert len(load(out)) == 1
    with pytest.raises(BadValue, match="^shuffle: got 'trial', expected never with pictures of a real box"):
        study("flips", **{**PLAYED, "p": [0.0], "shuffle": "trial"}, plant=spelled)


@pytest.mark.parametrize(
    ("plant", "folder", "line"),
    [
        ("twin?tilt=0", "shots", "camera: got 'shots', expected --plant manual with it; twin has no such option"),
        ("manual", "", "camera: got '', expected a folder"),
        (
            "manual?camera=others",
            "shots",
            "camera: got 'shots', expected none with manual?camera=others, which has ano",
        ),
        ("manual", "shots", "shots/handles.toml: no such file; it says where pictures show the handles"),
    ],
)
def test_what_no_camera_can_be_for_is_refused_in_one_line(tmp_path, plant, folder, line):
    done = typed("run", "flips", "--agent", "random", "--plant", plant, "--camera", folder, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(f"lockprobe: {line}")
    assert list(tmp_path.iterdir()) == []
