"""How often positions read from pictures are right, on pictures of the twin.

    python benchmarks/position_reader.py [--scenes]

Prints, per box and looks, the joints read rightly, the pictures with an unclear joint, and the processor time per
picture. ``--scenes`` takes the 16 scenes of ``run looks`` instead of plain and varied looks, and adds a sum.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from lockprobe_robot.hardware.camera import Shot
from lockprobe_robot.hardware.position_reader import Unclear, read_positions

from lockprobe.boxes.families import box
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.options.studyfile import study

SEEDS, ATTEMPTS = 3, 6
SCENES = "--scenes" in sys.argv

asked = study("looks")
plants = list(asked.plants) if SCENES else ["fast-twin?looks=plain", "fast-twin?looks=varied"]
sums = np.zeros(4, dtype=int)
for spec in plants:
    for name in ("chain-4", "random-6-3"):
        right = wrong = unclear = 0
        seconds = 0.0
        for seed in range(SEEDS):
            puzzle, rng = box(name), np.random.default_rng(seed)
            labels = tuple("ABCDEFGH"[: len(puzzle.joints)])
            plant = resolve_plant(spec).make(puzzle, labels, np.random.default_rng(seed))
            snapshot = plant.observe()
            for _ in range(ATTEMPTS):
                assert snapshot.look is not None
                frame = snapshot.look()
                places = frame.camera.project(frame.handles)[..., :2].tolist()
                began = time.process_time()
                try:
                    read = read_positions(Shot(rgb=frame.rgb), places, puzzle.names)
                    agreed = sum(a == b for a, b in zip(read, snapshot.configuration, strict=True))
                    right, wrong = right + agreed, wrong + len(read) - agreed
                except Unclear:
                    unclear += 1
                seconds += time.process_time() - began
                snapshot = plant.attempt(int(rng.integers(len(puzzle.joints))))
            plant.close()
        pictures = SEEDS * ATTEMPTS
        sums += (right, wrong, unclear, pictures)
        each = f"{seconds / pictures:.3f} s"
        print(f"{name}, {spec}: {right} joints right, {wrong} wrong, {unclear} of {pictures} pictures unclear, {each}")
right, wrong, unclear, pictures = sums.tolist()
print(f"all: {right} joints right, {wrong} wrong, {unclear} of {pictures} pictures unclear")
