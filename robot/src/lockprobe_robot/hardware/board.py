"""The pose of a real board in front of a robot, from a calibration."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.inputs import read_input
from lockprobe.trial.record import Fact
from lockprobe_robot.box_model.panel import PanelLayout, lay_out_panel
from lockprobe_robot.box_model.tag_layout import board_checksum, place_tags
from lockprobe_robot.calibration.calibration_file import calibration_for
from lockprobe_robot.calibration.pose import array_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Board:
    """A board whose pose is known.

    Attributes:
        panel: Its dimensions, and its pose in the frame of the arm's base, metres.
        facts: How the pose was found, for the record.
    """

    panel: PanelLayout
    facts: Mapping[str, Fact] = field(default_factory=dict)


def calibrated_board(box: Lockbox, path: Path | str, *, box_file: Path | str | None = None) -> Board:
    """A board at the pose that ``lockprobe rig calibrate`` found.

    Call it before the robot is connected, so that an unreliable calibration refuses the study before the first motion.

    Args:
        box: The box that the study plays.
        path: The calibration.
        box_file: The TOML file of the box, if it has one.

    Raises:
        BadFile: If the calibration cannot be read, belongs to another board, is older than the file of the box, or has
            a hold-out error above 4 mm.
    """
    panel = lay_out_panel(box)
    found = calibration_for(
        Path(path),
        board=board_checksum(panel, place_tags(panel)),
        board_file=None if box_file is None else Path(box_file),
    )
    facts: dict[str, Fact] = {
        "calibration_sha256": hashlib.sha256(read_input(Path(path))).hexdigest(),
        "calibration_held_out_mm": round(found.errors.held_out_mm, 3),
    }
    return Board(panel=replace(panel, pose=array_of(found.board_in_base)), facts=facts)
