"""Pictures of the twin in a folder, to rehearse ``lockprobe run --plant manual?camera=FOLDER`` without a camera.

    uv run python examples/twin_camera.py FOLDER [BOX]

It writes FOLDER/handles.toml and a picture of the start. Then type the joint that Lockprobe asks for; the twin moves it
if it goes, and the next picture shows it. Enter alone sets the box up for the next trial, q ends.
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

import lockprobe
from lockprobe import Snapshot
from lockprobe.boxes.box import Lockbox
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.trial.pictures.frame import Frame


def handles_toml(frame: Frame, names: Sequence[str]) -> str:
    """Where the picture shows the handle of each joint at 0 and at 1, as a file."""
    height, width, _ = frame.rgb.shape
    places = np.round(frame.camera.project(frame.handles)[..., :2]).astype(int).tolist()
    tables = (f"\n[{name}]\nat_0 = {at_0}\nat_1 = {at_1}\n" for name, (at_0, at_1) in zip(names, places, strict=True))
    return f"width = {width}\nheight = {height}\n{''.join(tables)}"


def photograph(folder: Path, box: Lockbox, ask: Callable[[str], str] = input) -> None:
    """Write the file of handles; then a picture of the start, and one after every answer."""
    number = 0

    def keep(snapshot: Snapshot) -> Frame:
        nonlocal number
        number += 1
        assert snapshot.look is not None
        frame = snapshot.look()
        Image.fromarray(frame.rgb).save(folder / f"{number:03}.png")
        print(f"{folder / f'{number:03}.png'}: {''.join(map(str, map(int, snapshot.configuration)))}")
        return frame

    source, joints = resolve_plant("fast-twin"), ", ".join(box.names)
    answer = ""
    while answer != "q":
        twin = source.make(box, tuple("ABCDEFGH"[: len(box.names)]), np.random.default_rng(1))
        frame = keep(twin.observe())
        if number == 1:
            (folder / "handles.toml").write_text(handles_toml(frame, box.names), "utf-8")
        while (answer := ask(f"Joint ({joints}), Enter for a new trial, q to end: ").strip()) not in ("", "q"):
            if answer in box.names:
                keep(twin.attempt(box.names.index(answer)))
        twin.close()


if __name__ == "__main__":
    pictures = Path(sys.argv[1])
    pictures.mkdir(exist_ok=True)
    photograph(pictures, lockprobe.box(*sys.argv[2:] or ["chain-4"]))
