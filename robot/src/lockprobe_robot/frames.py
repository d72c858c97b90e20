"""``lockprobe export --format frames``: pictures of trials as files, with the camera, the truth and the report.

Every trial is played again on its plant, or on a fast-twin where that has no camera, and photographed before its first
step and after each. Pictures show the truth, whatever the agent was shown.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lockprobe.boxes.box import bits
from lockprobe.foundation.errors import BadFile, BadValue, TrialFault
from lockprobe.foundation.storage.atomic_file import make_directory, refuse_links, writing
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.trial.pictures.frame import to_millimetres, to_png
from lockprobe_robot.film.make import WITHOUT_ARM, plan_of, played_again


def write_frames(directory: Path, out: Path, *, only: str, tell: Callable[[str], None]) -> int:
    """Write the frames of a study: ``rgb/000001.png``, ``depth/000001.png``, and a line for each in ``frames.jsonl``.

    Depth files hold whole millimetres along the optical axis in 16 bits, 0 where there is no reading. A line has the
    pinhole camera (``fx``, ``fy``, ``cx``, ``cy``, from the middle of the top left pixel), the pose of the panel in
    its frame, both places of every handle in the frame of the panel (metres), and of the trial: its key, the step, the
    joint that was attempted, the truth and what was told.

    Args:
        directory: The study's directory.
        out: A directory that does not exist or is empty.
        only: Only trials whose key begins or ends so; empty for all.
        tell: Called with one line after every trial.

    Returns:
        The number of frames.

    Raises:
        UserMistake: If there is no such trial, or a trial goes another way than it did.
    """
    trials = [trial for trial in load(directory) if trial.key.startswith(only) or trial.key.endswith(only)]
    if not trials:
        raise BadValue("--trial", only, "the key of a trial, or its beginning or end")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadFile(out, "is there and not an empty directory; choose another")
    study = read_study(directory)
    refuse_links(out)
    count, target = 0, out.resolve()
    make_directory(target.parent)
    with writing(out), TemporaryDirectory(prefix=".", suffix=".draft", dir=target.parent) as made:
        draft = Path(made, "frames")
        for kind in ("rgb", "depth"):
            (draft / kind).mkdir(parents=True)
        with (draft / "frames.jsonl").open("w", encoding="utf-8") as table:
            for number, trial in enumerate(trials, start=1):
                plan = plan_of(study, trial)
                source = resolve_plant(plan.plant)
                if source.picture_size is None:
                    source = resolve_plant(WITHOUT_ARM)
                source.check(plan.box)
                plant = source.make(plan.box, plan.names.labels, plan.luck.physics())
                try:
                    for at, snapshot, differs in played_again(trial, plant):
                        if differs is not None:
                            raise BadFile(trial.key, differs)
                        assert snapshot.look is not None
                        frame, count = snapshot.look(), count + 1
                        camera, handles = frame.camera, zip(trial.joints, frame.handles, strict=True)
                        files = {kind: f"{kind}/{count:06}.png" for kind in ("rgb", "depth")}
                        line = {
                            **files,
                            "width": camera.width,
                            "height": camera.height,
                            "fx": camera.focal,
                            "fy": camera.focal,
                            "cx": (camera.width - 1) / 2,
                            "cy": (camera.height - 1) / 2,
                            "panel_in_camera": np.round(camera.panel, 9).tolist(),
                            "handles": {name: np.round(places, 6).tolist() for name, places in handles},
                            "labels": dict(zip(trial.joints, trial.labels, strict=True)),
                            "key": trial.key,
                            "agent": trial.agent,
                            "step": at + 1,
                        }
                        if at >= 0:
                            step = trial.steps[at]
                            line |= {"joint": step.joint, "moved": step.moved, "told_moved": step.told_moved}
                            line |= {"told_state": step.told_state, "told": step.told}
                        (draft / files["rgb"]).write_bytes(to_png(frame.rgb))
                        (draft / files["depth"]).write_bytes(to_png(to_millimetres(frame.depth)))
                        table.write(json.dumps({**line, "state": bits(snapshot.configuration)}) + "\n")
                except TrialFault as fault:
                    raise BadFile(trial.key, f"it breaks when it is played again ({fault})") from None
                tell(f"trial {number} of {len(trials)}, {count} frames")
        draft.replace(target)
    return count
