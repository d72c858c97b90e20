"""``lockprobe run --plant manual?camera=FOLDER``: pictures tell the truth."""

import pytest
from lockprobe_robot.hardware import sight
from plants.person import Person, handles_text
from typed import in_process

from lockprobe.boxes.families import box
from lockprobe.cli.run import run
from lockprobe.foundation.errors import BadFile, BadValue
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


@pytest.mark.usefixtures("folder")
def test_a_folder_is_played_and_the_study_is_that_of_the_spec(tmp_path):
    out, spelled = tmp_path / "s", f"manual?camera={tmp_path}/A%26B 100%25%2B"
    run("flips", plant=spelled, out=out, report=False, **PLAYED)
    (trial,) = load(out)
    assert (trial.ending, trial.plant["truth"], trial.plant["plant"]) == ("solved", "camera", spelled)
    assert read_study(out).identity == study("flips", **{**PLAYED, "p": [0.0]}, plant=spelled).identity
    run("flips", plant=spelled, out=out, report=False, **PLAYED)
    assert len(load(out)) == 1
    with pytest.raises(BadValue, match="^shuffle: got 'trial', expected never with pictures of a real box"):
        study("flips", **{**PLAYED, "p": [0.0], "shuffle": "trial"}, plant=spelled)


def test_a_folder_without_places_of_handles_is_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadFile, match="^shots/handles.toml: no such file; it says where pictures show the handles.*$"):
        in_process("run", "flips", "--agent", "random", "--plant", "manual?camera=shots")
    assert list(tmp_path.iterdir()) == []
