"""A board's pose from a calibration: it leads the hand, the record names it, and a bad one refuses the study."""

import hashlib
import os
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from builders import small_study
from calibration import tagged
from hardware.fakes import CALIBRATION, CONNECTED
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.box_model.tag_layout import board_checksum, place_tags
from lockprobe_robot.calibration.calibration_file import Calibration, CalibrationErrors, write_calibration
from lockprobe_robot.calibration.pose import rows_of
from lockprobe_robot.hardware.board import Board, calibrated_board

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.plugins import allow
from lockprobe.studies.running.runner import run_study

CHAIN = box("chain-4")
POSE = np.array([[0, 1, 0, 0.52], [-1, 0, 0, 0.03], [0, 0, 1, 0.17], [0, 0, 0, 1]])


def write(path, *, held_out_mm=1.25, of=CHAIN, year=2026):
    panel = lay_out_panel(of)
    errors = dict.fromkeys(CalibrationErrors.model_fields, 0.1) | {"held_out_mm": held_out_mm}
    found = Calibration(
        date=datetime(year, 11, 20, tzinfo=UTC), box=of.name, board=board_checksum(panel, place_tags(panel)), tag_mm=40.0,
        camera=tagged.CAMERA, method="park", camera_in_hand=rows_of(tagged.eye()), board_in_base=rows_of(POSE),
        used=("0.png",), refused={}, turned_degrees=25.0, errors=CalibrationErrors(**errors),
    )  # fmt: skip
    write_calibration(found, path)
    return path


@pytest.fixture
def study(tmp_path):
    CONNECTED.clear()
    CALIBRATION.clear()
    CALIBRATION["path"] = tmp_path / "calibration.json"
    small = small_study(["human-inspired"], p=[0.0], repetitions=1, trials=1)
    allow(plant := "python:hardware.fakes:calibrated_rig")
    return replace(small, plant=plant)


def test_the_hand_follows_the_measured_board_and_the_record_names_the_calibration(study, tmp_path):
    path = write(CALIBRATION["path"])
    (played,) = run_study(study, tmp_path / "out")
    assert played.error is None
    assert played.plant["calibration_held_out_mm"] == 1.25
    assert played.plant["calibration_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    measured, known = calibrated_board(CHAIN, path), Board(panel=replace(lay_out_panel(CHAIN), pose=POSE))
    drawn = lay_out_panel(CHAIN).handle_path
    for joint in range(4):
        assert measured.panel.handle_path(joint, True).points == pytest.approx(
            known.panel.handle_path(joint, True).points
        )
        assert measured.panel.handle_path(joint, True).length == pytest.approx(drawn(joint, True).length)
    assert measured.panel.handle_path(0, False).axis == pytest.approx([0, 0, -1])


REFUSALS = {
    "coarse": ({"held_out_mm": 4.2}, "hold-out error 4.2 mm, but the arm tolerates 4 mm"),
    "other board": ({"of": box("random-6-3")}, "a calibration of another board"),
    "older than the box": ({"year": 2020}, "from 2020-11-20 00:00, but .*box.toml is from"),
    "missing": (None, "calibration.json"),
}


@pytest.mark.parametrize(("written", "why"), REFUSALS.values(), ids=REFUSALS)
def test_a_study_does_not_start_on_a_calibration_that_cannot_be_relied_on(study, tmp_path, written, why):
    """Nothing is connected, nothing moves, and there is no study directory with a broken trial."""
    CALIBRATION["box_file"] = tmp_path / "box.toml"
    CALIBRATION["box_file"].touch()
    moment = datetime(2025, 1, 1, tzinfo=UTC).timestamp()
    os.utime(CALIBRATION["box_file"], (moment, moment))
    if written is not None:
        write(CALIBRATION["path"], **written)
    with pytest.raises(BadFile, match=why) as caught:
        run_study(study, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert CONNECTED == []
    assert not (tmp_path / "out").exists()
