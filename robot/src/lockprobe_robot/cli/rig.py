"""``lockprobe rig``: the check and the calibration of a robot before it moves a box."""

from __future__ import annotations

import json as json_
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, PlantFault, UserMistake

if TYPE_CHECKING:
    from lockprobe_robot.hardware.check import FreeMotion

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

_PLANT = "rig?rung=scripted|twin, or your rig as python:MODULE:NAME"

_NEAR = 1.0
"""Pixels by which corners miss their places at most if the tags are those of the board."""

NOT_GOOD = 1
"""The exit status if an arm is not good enough."""


@app.command()
def check(
    plant: Annotated[str, typer.Option(help=options.with_brackets(options.PLANT, _PLANT))] = "rig?rung=twin",
    box: options.Box = DEFAULT_BOX,
    json: options.AsJson = False,
) -> None:
    """Make every joint's motion 100 mm above the handles, in both directions, without touching them.

    The operator has to agree first. A force of 10 N or a sinking hand stops the arm. Exit status 1: the arm is not
    good enough to touch the board.
    """
    import numpy as np

    from lockprobe.foundation.plugins import allow
    from lockprobe.plants.catalogue import resolve_plant
    from lockprobe_robot.hardware.bounds import call_driver
    from lockprobe_robot.hardware.check import check_rig
    from lockprobe_robot.hardware.rig import Rig

    motions: list[FreeMotion] = []

    def tell(made: FreeMotion) -> None:
        motions.append(made)
        way = f"{made.start} to {1 - made.start}"
        measured = f"force {made.force:.1f} N, off by {1000 * made.astray:.1f} mm, {1000 * made.lowest:.0f} mm above"
        if not json:
            print(f"{made.joint:16} {way}  {made.verdict}, {measured}{'' if made.verdict == 'moved' else '  <- WRONG'}")

    allow(plant)
    asked, source = find_box(box), resolve_plant(plant)
    try:  # no trial runs that a fault could end as an error
        rig = call_driver("the rig", lambda: source.make(asked, asked.names, np.random.default_rng(0)))
        try:
            if not isinstance(rig, Rig):
                raise BadValue("plant", plant, _PLANT)
            complaints = check_rig(rig, tell=tell)
        finally:
            rig.close()
    except PlantFault as fault:
        raise UserMistake(str(fault)) from None
    if json:
        made = [asdict(one) for one in motions]
        print(json_.dumps({"motions": made, "complaints": complaints, "facts": dict(rig.facts)}))
    else:
        print(f"Late: {rig.arm.late} of {rig.arm.commands} commands")
        force, astray = (max(getattr(one, what) for one in motions) for what in ("force", "astray"))
        print(f"In free air: greatest force {force:.1f} N, off by at most {1000 * astray:.1f} mm")
        print("\n".join(f"Not good enough: {complaint}." for complaint in complaints) or "Good enough.")
    if complaints:
        raise typer.Exit(NOT_GOOD)


@app.command()
def calibrate(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Pictures and views.json (robot/docs/robot.md).")],
    box: options.Box = DEFAULT_BOX,
    tag_size: Annotated[
        float, typer.Option(min=10, max=200, metavar="MM", help="Measured side of a printed tag's black square.")
    ] = 40.0,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help=options.with_brackets(options.OUT, "FOLDER/calibration.json"))
    ] = None,
    json: options.AsJson = False,
) -> None:
    """Find the pose of the camera in the hand and of the board in the robot's base, from pictures of tags.

    --box is the box on the board in the pictures.
    """
    from lockprobe.foundation.storage.atomic_file import write_file
    from lockprobe_robot.box_model.panel import lay_out_panel
    from lockprobe_robot.calibration import calibrate as library
    from lockprobe_robot.calibration.calibration_file import TOLERATED_MM

    asked = find_box(box)
    found = library.calibrate(folder, lay_out_panel(asked), asked.name, side=tag_size / 1000)
    path = out or folder / "calibration.json"
    write_file(path, found.model_dump_json(indent=2) + "\n")
    for picture, reason in found.refused.items():
        print(f"refused {picture}: {reason}", file=sys.stderr)
    if found.held_out_mm > TOLERATED_MM or found.reprojection_px > _NEAR:
        check = "--box, --tag-size, the places of the tags, the camera's numbers, the poses of the hand (metres)"
        print(f"a study accepts {TOLERATED_MM:g} mm and tags within {_NEAR:g} pixel: check {check}", file=sys.stderr)
    if json:
        print(json_.dumps(found.model_dump(mode="json")))
        return
    print(f"{found.box}: {len(found.used)} of {len(found.used) + len(found.refused)} views used")
    print(f"hold-out error: {found.held_out_mm:.2f} mm, worst view {found.held_out_worst_mm:.2f} mm")
    print(f"corners in the pictures: {found.reprojection_px:.2f} pixels")
    print(f"rotation of the hand off its most frequent axis: {found.turned_degrees:.0f} degrees")
    for name, pose in (("camera in hand", found.camera_in_hand), ("board in base", found.board_in_base)):
        x, y, z = (1000 * row[3] for row in pose[:3])
        print(f"{name}: {x:.1f}, {y:.1f}, {z:.1f} mm")
    print(path)
