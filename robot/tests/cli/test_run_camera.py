"""``lockprobe run --plant manual?camera=FOLDER``: what is refused before anybody takes a picture."""

import pytest
from lockprobe_robot.hardware import sight
from plants.person import Person, handles_text
from typed import in_process

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.options.studyfile import study

FIVE = "random-5-3"


def test_a_folder_whose_name_has_to_be_encoded_is_a_plant_and_its_panel_is_never_shuffled(tmp_path, monkeypatch):
    (made := tmp_path / "A&B 100%+").mkdir()
    (made / "handles.toml").write_text(handles_text(box(FIVE)), "utf-8")
    monkeypatch.setattr(sight, "TerminalOperator", lambda: Person(box(FIVE), folder=made))
    asked = {"agent": "viewer", "box": FIVE, "modality": "rgb", "plant": f"manual?camera={tmp_path}/A%26B 100%25%2B"}
    resolve_plant(study("flips", shuffle="never", **asked).plant).check(box(FIVE))
    with pytest.raises(BadValue, match="^shuffle: got 'trial', expected never with pictures of a real box"):
        study("flips", shuffle="trial", **asked)


def test_a_folder_without_places_of_handles_is_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadFile, match="^shots/handles.toml: no such file; it says where pictures show the handles.*$"):
        in_process("run", "flips", "--agent", "random", "--plant", "manual?camera=shots")
    assert list(tmp_path.iterdir()) == []
