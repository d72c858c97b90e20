"""``lockprobe rig calibrate``: calibrates a robot's camera and board from pictures of tags."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue

if TYPE_CHECKING:
    from lockprobe_robot.calibration.calibration_file import Calibration

_SMALLEST, _LARGEST = 10.0, 200.0
"""Accepted sides of a printed tag, millimetres."""

_NEAR = 1.0
"""Pixels by which corners miss their places at most if the tags are those of the board."""


def calibrate(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Pictures and views.json (robot/docs/robot.md).")],
    box: options.Box = DEFAULT_BOX,
    tag_size: Annotated[
        float | None, typer.Option(metavar="MM", help="Measured side of a printed tag's black square (as drawn).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help=options.with_brackets(options.OUT, "FOLDER/calibration.json"))
    ] = None,
    json: options.AsJson = False,
) -> None:
    """Find the pose of the camera in the hand and of the board in the robot's base, from pictures of tags.

    --box is the box on the board in the pictures.
    """
    from lockprobe_robot.box_model.panel import lay_out_panel
    from lockprobe_robot.box_model.tag_layout import board_checksum, place_tags, resized
    from lockprobe_robot.calibration import calibrate as library
    from lockprobe_robot.calibration.calibration_file import write_calibration
    from lockprobe_robot.calibration.views import read_views

    if tag_size is not None and not _SMALLEST <= tag_size <= _LARGEST:
        raise BadValue("--tag-size", tag_size, f"millimetres from {_SMALLEST:g} to {_LARGEST:g}")
    views, found = read_views(folder), find_box(box)
    panel = lay_out_panel(found)
    drawn = place_tags(panel)
    printed = drawn if tag_size is None else resized(drawn, tag_size / 1000)
    seen, refused = library.look_at_views(folder, views, printed)
    for picture, reason in refused.items():
        print(f"refused {picture}: {reason}", file=sys.stderr)
    result = library.calibrate(
        seen,
        refused,
        camera=views.camera,
        tags=printed,
        box=found.name,
        board=board_checksum(panel, drawn),
    )
    path = folder / "calibration.json" if out is None else out
    write_calibration(result, path)
    _tell(result, path, json=json)


def _tell(result: Calibration, path: Path, *, json: bool) -> None:
    """Print the calibration with its errors, and a warning if a study would refuse it."""
    from lockprobe_robot.calibration.calibration_file import TOLERATED_MM

    errors, views = result.errors, len(result.used) + len(result.refused)
    too_far = errors.held_out_mm > TOLERATED_MM
    if too_far:
        print(f"the arm tolerates {TOLERATED_MM:g} mm: a study refuses this calibration", file=sys.stderr)
    if errors.reprojection_px > _NEAR:
        print("check --box, --tag-size, the numbers of the camera, and the place of every tag", file=sys.stderr)
    elif too_far:
        print("check the poses of the hand: metres, at the time of the picture", file=sys.stderr)
    if json:
        print(json_.dumps(result.model_dump(mode="json")))
        return
    print(f"{result.box}: {len(result.used)} of {views} views used, {len(result.refused)} refused ({result.method})")
    print(f"hold-out error: {errors.held_out_mm:.2f} mm, worst view {errors.held_out_worst_mm:.2f} mm")
    print(
        f"                {errors.held_out_degrees:.2f} degrees, worst view {errors.held_out_worst_degrees:.2f} degrees"
    )
    print(f"corners in the pictures: {errors.reprojection_px:.2f} pixels")
    print(f"rotation of the hand off its most frequent axis: {result.turned_degrees:.0f} degrees")
    for name, pose in (("camera in hand", result.camera_in_hand), ("board in base", result.board_in_base)):
        x, y, z = (1000 * row[3] for row in pose[:3])
        print(f"{name}: {x:.1f}, {y:.1f}, {z:.1f} mm")
    print(path)
