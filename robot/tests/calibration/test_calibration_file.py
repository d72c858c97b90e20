"""A calibration comes back from its file, and a study refuses one that it cannot rely on."""

import json
import os
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from calibration import tagged
from lockprobe_robot.calibration.calibration_file import (
    Calibration,
    CalibrationErrors,
    calibration_for,
    read_calibration,
    write_calibration,
)
from lockprobe_robot.calibration.pose import rows_of

from lockprobe.foundation.errors import BadFile

BOARD = "ab" * 32


def calibration(held_out_mm=1.2, date=datetime(2026, 11, 20, tzinfo=UTC)):
    errors = CalibrationErrors(
        held_out_mm=held_out_mm, held_out_worst_mm=9.0, held_out_degrees=0.1, held_out_worst_degrees=0.2,
        reprojection_px=0.3,
    )  # fmt: skip
    return Calibration(
        date=date, box="chain-2", board=BOARD, tag_mm=40.0, camera=tagged.CAMERA, method="park",
        camera_in_hand=rows_of(tagged.eye()), board_in_base=rows_of(np.eye(4)), used=("0.png",), refused={"1.png": "no"},
        turned_degrees=25.0, errors=errors,
    )  # fmt: skip


@pytest.fixture
def path(tmp_path):
    write_calibration(calibration(), tmp_path / "calibration.json")
    return tmp_path / "calibration.json"


def test_what_is_written_is_read(path):
    assert read_calibration(path) == calibration()
    assert calibration_for(path, board=BOARD) == calibration()


def test_another_board_is_refused(path):
    with pytest.raises(BadFile, match="of another board .box chain-2.: run lockprobe rig calibrate again"):
        calibration_for(path, board="cd" * 32)


@pytest.mark.parametrize(("days", "refused"), [(-1, False), (1, True)])
def test_one_that_is_older_than_the_board_s_file_is_refused(path, tmp_path, days, refused):
    board_file = tmp_path / "board.toml"
    board_file.touch()
    moment = (calibration().date + timedelta(days=days)).timestamp()
    os.utime(board_file, (moment, moment))
    if refused:
        with pytest.raises(BadFile, match=r"from 2026-11-20 00:00, but .*board.toml is from 2026-11-21 00:00"):
            calibration_for(path, board=BOARD, board_file=board_file)
    else:
        assert calibration_for(path, board=BOARD, board_file=board_file)
    with pytest.raises(BadFile, match="none.toml: cannot be read"):
        calibration_for(path, board=BOARD, board_file=tmp_path / "none.toml")


@pytest.mark.parametrize(("millimetres", "refused"), [(4.0, False), (4.1, True)])
def test_one_worse_than_the_arm_tolerates_is_refused(tmp_path, millimetres, refused):
    write_calibration(calibration(held_out_mm=millimetres), tmp_path / "c.json")
    if refused:
        with pytest.raises(BadFile, match="hold-out error 4.1 mm, but the arm tolerates 4 mm"):
            calibration_for(tmp_path / "c.json", board=BOARD)
    else:
        assert calibration_for(tmp_path / "c.json", board=BOARD)


@pytest.mark.parametrize(
    ("key", "value"),
    [("board", "x"), ("date", "2026-11-20"), ("schema_version", 2), ("camera_in_hand", [[1] * 4] * 4), ("more", 1)],
)
def test_a_file_that_was_changed_by_hand_is_refused_in_one_line(path, key, value):
    path.write_text(json.dumps(json.loads(path.read_text()) | {key: value}))
    with pytest.raises(BadFile, match=key) as caught:
        read_calibration(path)
    assert "\n" not in str(caught.value)


def test_an_error_that_is_no_number_is_refused(path):
    data = json.loads(path.read_text())
    data["errors"]["held_out_mm"] = float("nan")
    path.write_text(json.dumps(data))
    with pytest.raises(BadFile, match="errors.held_out_mm"):
        calibration_for(path, board=BOARD)
