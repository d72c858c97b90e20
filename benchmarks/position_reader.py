"""How often positions read from pictures are right, on pictures of the twin.

    python benchmarks/position_reader.py

Prints, per box and looks, the joints read rightly, those unclear, and the processor time per picture.
"""

from __future__ import annotations

import time

import numpy as np
from lockprobe_robot.hardware.camera import Shot
from lockprobe_robot.hardware.position_reader import Unclear, read_positions

from lockprobe.boxes.families import box
from lockprobe.plants.catalogue import resolve_plant

SEEDS, ATTEMPTS = 3, 6

for looks in ("plain", "varied"):
    for name in ("chain-4", "random-6-3"):
        right = unclear = joints = 0
        seconds = 0.0
        for seed in range(SEEDS):
            puzzle, rng = box(name), np.random.default_rng(seed)
            labels = tuple("ABCDEFGH"[: len(puzzle.joints)])
            plant = resolve_plant(f"fast-twin?looks={looks}").make(puzzle, labels, np.random.default_rng(seed))
            snapshot = plant.observe()
            for _ in range(ATTEMPTS):
                assert snapshot.look is not None
                frame = snapshot.look()
                places = frame.camera.project(frame.handles)[..., :2].tolist()
                began = time.process_time()
                try:
                    read = read_positions(Shot(rgb=frame.rgb), places, puzzle.names)
                    right += sum(a == b for a, b in zip(read, snapshot.configuration, strict=True))
                except Unclear:
                    unclear += 1
                seconds += time.process_time() - began
                joints += len(puzzle.joints)
                snapshot = plant.attempt(int(rng.integers(len(puzzle.joints))))
            plant.close()
        pictures = SEEDS * ATTEMPTS
        print(
            f"{name}, {looks}: {right} of {joints} joints right, {unclear} pictures unclear, {seconds / pictures:.3f} s"
        )
