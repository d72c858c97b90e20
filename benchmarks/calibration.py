"""Errors of a calibration on pictures of the twin, where every pose is known.

AprilTags lie on the panel of a box. A camera on a hand takes pictures of them from 20 poses; the poses that the robot
reports have noise. Every row is a folder as ``lockprobe rig calibrate`` reads it, made with several seeds.

    python benchmarks/calibration.py [--box chain-4] [--seeds 5] [--views 20] [--keep DIRECTORY]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from lockprobe_robot.calibration.calibrate import (
    FEWEST_TAGS,
    LEAST_TURN,
    calibrate,
    look_at_views,
    turned_degrees,
)
from lockprobe_robot.calibration.opencv import METHODS
from lockprobe_robot.calibration.pose import Pose, angle_between, array_of
from lockprobe_robot.calibration.views import VIEWS_FILE, read_views
from lockprobe_robot.scene.panel import PanelLayout, lay_out_panel
from lockprobe_robot.scene.scene import build_scene
from lockprobe_robot.scene.tag_layout import TagLayout, board_checksum, place_tags
from lockprobe_robot.twin_settings import SceneSettings
from scipy.spatial.transform import Rotation

import lockprobe
from lockprobe.foundation.errors import UserMistake
from lockprobe.trial.pictures.png import to_png

sys.path.append(str(Path(__file__).parents[1] / "robot" / "tests" / "calibration"))
from tag_pictures import PAPER, HandCamera, add_tag_prints, tag_bits

SIZE = (640, 480)
ROBOT_MM, ROBOT_DEGREES = 0.2, 0.05
"""Standard deviation of each coordinate of the hand's pose."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row.

    Attributes:
        name: What it is.
        fovy: Vertical field of view, degrees.
        grey: Standard deviation of the noise of each pixel, of 255.
        astray: How far the camera aims past the middle of the board, metres: tags are cut by the picture's edge.
        tilt: Largest tilt of the camera about two axes, degrees.
        roll: Largest roll about the optical axis, degrees.
    """

    name: str
    fovy: float = 58.0
    grey: float = 0.0
    astray: float = 0.03
    tilt: float = 25.0
    roll: float = 45.0


CASES = (
    Case(name="as it is"),
    Case(name="noise of 5 grey levels", grey=5.0),
    Case(name="noise of 15 grey levels", grey=15.0),
    Case(name="tags half out of view (42 degrees)", fovy=42.0, astray=0.06, grey=5.0),
    Case(name="less rotation (12 degrees)", tilt=12.0, roll=12.0, grey=5.0),
    Case(name="little rotation (3 degrees)", tilt=3.0, roll=3.0, grey=5.0),
)


def camera_in_hand() -> Pose:
    """The pose that a calibration has to find."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("zyx", [92, -8, 5], degrees=True).as_matrix()
    pose[:3, 3] = (0.055, -0.032, 0.041)
    return pose


def on_paper() -> Pose:
    """The printed tags in the frame of the panel: as high above the board as paper is thick."""
    pose = np.eye(4)
    pose[2, 3] = PAPER
    return pose


def camera_pose(panel: PanelLayout, case: Case, rng: np.random.Generator) -> Pose:
    """A pose of the camera that looks at the board."""
    tilts, roll = np.radians(case.tilt) * rng.uniform(-1, 1, 2), np.radians(case.roll) * rng.uniform(-1, 1)
    turn = Rotation.from_euler("x", np.pi) * Rotation.from_euler("xyz", [*tilts, roll])
    aim = np.array([*(case.astray * rng.uniform(-1, 1, 2) * (1.5, 1.0)), 0.0])
    local = np.eye(4)
    local[:3, :3] = turn.as_matrix()
    local[:3, 3] = aim - rng.uniform(0.50, 0.70) * local[:3, 2]
    return panel.pose @ local


def disturbed(pose: Pose, rng: np.random.Generator) -> Pose:
    """The pose as a robot reports it."""
    told = pose.copy()
    turn = Rotation.from_rotvec(np.radians(ROBOT_DEGREES) * rng.standard_normal(3))
    told[:3, :3] = turn.as_matrix() @ told[:3, :3]
    told[:3, 3] += 1e-3 * ROBOT_MM * rng.standard_normal(3)
    return told


def write_folder(
    folder: Path, camera: HandCamera, panel: PanelLayout, case: Case, count: int, rng: np.random.Generator
) -> dict[str, Pose]:
    """Write pictures and ``views.json``; the true pose of the printed board in the camera by picture."""
    folder.mkdir(parents=True, exist_ok=True)
    views, truth = [], {}
    for number in range(count):
        pose, name = camera_pose(panel, case, rng), f"{number:02}.png"
        picture = camera.look(pose) + case.grey * rng.standard_normal((SIZE[1], SIZE[0], 1))
        (folder / name).write_bytes(to_png(np.clip(np.rint(picture), 0, 255).astype(np.uint8)))
        hand = disturbed(pose @ np.linalg.inv(camera_in_hand()), rng)
        views.append({"picture": name, "hand": hand.tolist()})
        truth[name] = np.linalg.inv(pose) @ panel.pose @ on_paper()
    focal, centre = [camera.focal] * 2, [(side - 1) / 2 for side in SIZE]
    facts = {"width": SIZE[0], "height": SIZE[1], "focal": focal, "centre": centre}
    (folder / VIEWS_FILE).write_text(json.dumps({"camera": facts, "views": views}, indent=1), "utf-8")
    return truth


def spread(values: Sequence[float], unit: str) -> str:
    """Mean, standard deviation and largest value."""
    deviation = np.std(values, ddof=1) if len(values) > 1 else float("nan")
    return f"{np.mean(values):.2f} ± {deviation:.2f}, at most {max(values):.2f} {unit}"


@dataclass
class Measured:
    """What one case came to, over all seeds."""

    tried: int = 0
    seconds: float = 0.0
    turned: list[float] = field(default_factory=list)
    by_tags: dict[int, list[tuple[float, float]]] = field(default_factory=lambda: defaultdict(list))
    refusals: list[str] = field(default_factory=list)
    stopped: list[str] = field(default_factory=list)
    found: dict[str, list[tuple[float, ...]]] = field(default_factory=lambda: defaultdict(list))


def measure(case: Case, panel: PanelLayout, tags: TagLayout, name: str, options: argparse.Namespace) -> None:
    """Print the rows of one case."""
    labels = tuple("ABCDEFGH"[: len(panel.mounted_joints)])
    scene = build_scene(lockprobe.box(name), labels=labels, settings=SceneSettings(), rng=np.random.default_rng(1))
    add_tag_prints(scene.spec, tags, tag_bits(range(4)))
    camera = HandCamera(scene.spec, width=SIZE[0], height=SIZE[1], fovy=case.fovy)
    measured = Measured()
    for seed in range(1, options.seeds + 1):
        folder = Path(options.keep or options.scratch) / f"{CASES.index(case)}-{seed}"
        truth = write_folder(folder, camera, panel, case, options.views, np.random.default_rng(seed))
        one_folder(folder, truth, case, panel, tags, name, measured)
    camera.close()
    print(f"\n{case.name} ({camera.name})")
    show(measured)


def one_folder(
    folder: Path,
    truth: dict[str, Pose],
    case: Case,
    panel: PanelLayout,
    tags: TagLayout,
    name: str,
    measured: Measured,
) -> None:
    """Calibrate with one folder by every method."""
    views = read_views(folder)
    start = time.process_time()
    seen, refused = look_at_views(folder, views, tags)
    measured.seconds += time.process_time() - start
    others = views.model_copy(update={"views": tuple(view for view in views.views if view.picture in refused)})
    for view in [*seen, *look_at_views(folder, others, tags, fewest_tags=1)[0]]:
        off = 1000 * float(np.linalg.norm((view.board - truth[view.picture])[:3, 3]))
        measured.by_tags[view.tags].append((off, angle_between(view.board, truth[view.picture])))
    measured.tried += len(views.views)
    measured.refusals += [reason.partition(" (")[0] for reason in refused.values()]
    measured.turned.append(turned_degrees([view.hand for view in seen]))
    if measured.turned[-1] < LEAST_TURN:
        measured.stopped.append(f"rotation off the most frequent axis below {LEAST_TURN:g} degrees")
    facts = {"camera": views.camera, "tags": tags, "box": name, "board": board_checksum(panel, tags)}
    for method in METHODS:
        try:
            result = calibrate(seen, refused, **facts, method=method, least_turn=0.0)
        except UserMistake as mistake:
            measured.stopped += [str(mistake)] * (method == METHODS[0])
            continue
        eye, base = array_of(result.camera_in_hand), array_of(result.board_in_base)
        measured.found[method].append((
            1000 * float(np.linalg.norm(eye[:3, 3] - camera_in_hand()[:3, 3])),
            angle_between(eye, camera_in_hand()),
            1000 * float(np.linalg.norm((base - panel.pose @ on_paper())[:3, 3])),
            result.errors.held_out_mm,
        ))  # fmt: skip


def show(measured: Measured) -> None:
    """Print the rows of one case."""
    cost = 1000 * measured.seconds / measured.tried
    turns = spread(measured.turned, "degrees")
    print(f"  rotation off the most frequent axis {turns}")
    print(f"  views {measured.tried}, refused {len(measured.refusals)}, {cost:.0f} ms of processor a view")
    for reason in sorted(set(measured.refusals)):
        print(f"    refused {measured.refusals.count(reason)} x: {reason}")
    for number, rows in sorted(measured.by_tags.items()):
        off, turned = zip(*rows, strict=True)
        print(f"  board in camera, {number} tags ({len(rows)} views): {spread(off, 'mm')}; {spread(turned, 'degrees')}")
    used = [row for number, rows in measured.by_tags.items() if number >= FEWEST_TAGS for row in rows]
    off, turned = zip(*used, strict=True)
    print(f"  board in camera, used ({len(used)} views): {spread(off, 'mm')}; {spread(turned, 'degrees')}")
    for reason in sorted(set(measured.stopped)):
        print(f"    refused by rig calibrate: {reason}")
    for method, rows in measured.found.items():
        eye_mm, eye_degrees, base_mm, held = zip(*rows, strict=True)
        print(f"  {method:10} {len(rows)} x hand-eye {spread(eye_mm, 'mm')}; {np.mean(eye_degrees):.2f} degrees")
        print(f"  {'':10} board in base {spread(base_mm, 'mm')}; hold-out {spread(held, 'mm')}")


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--box", default="chain-4")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--views", type=int, default=20)
    parser.add_argument("--case", type=int, help="only this row, from 0")
    parser.add_argument("--keep", type=Path, help="keep the folders of pictures here")
    options = parser.parse_args()
    box = lockprobe.box(options.box)
    panel = lay_out_panel(box)
    tags = place_tags(panel)
    print(f"{options.box}: four tags of {1000 * tags.side:g} mm, {options.seeds} seeds of {options.views} views")
    with tempfile.TemporaryDirectory() as scratch:
        options.scratch = scratch
        for number, case in enumerate(CASES):
            if options.case in (None, number):
                measure(case, panel, tags, options.box, options)


if __name__ == "__main__":
    main()
