"""Verdicts over the wire against the twin in this process, on boxes from the generator: the same random attempts.

    uv run --all-packages --extra wire python benchmarks/wire_rehearsal.py [--boxes 10] [--attempts 20] [--first 1]

Franka's client library drives a process that plays the robot with our arm and box. One attempt takes about 6 seconds of
wall time. Prints every attempt that is not as the rules have it, and the late ticks on both sides.
"""

from __future__ import annotations

import argparse

from lockprobe_robot.hardware.rehearsal import rehearse

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue


def main() -> None:
    """Play both rungs on every box."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--boxes", type=int, default=10)
    parser.add_argument("--attempts", type=int, default=20)
    parser.add_argument("--first", type=int, default=1)
    asked = parser.parse_args()
    total = right = equal = late = ticks = slow = played = 0
    seed = asked.first - 1
    while played < asked.boxes:
        seed += 1
        puzzle = box(f"random-{3 + seed % 4}-{seed}")
        try:
            twin = rehearse("twin", puzzle, attempts=asked.attempts, seed=seed)
        except BadValue as refused:
            print(f"{puzzle.name}: not built ({refused})", flush=True)
            continue
        wire = rehearse("wire", puzzle, attempts=asked.attempts, seed=seed)
        played += 1
        for ours, theirs in zip(wire.attempts, twin.attempts, strict=True):
            same = (ours.verdict, ours.true) == (theirs.verdict, theirs.true)
            total, right, equal = total + 1, right + ours.right, equal + same
            if not (same and ours.right):
                print(f"  {puzzle.name}: wire {ours}; twin {theirs.verdict or theirs.fault}", flush=True)
        late += wire.commands_late
        ticks, slow = ticks + wire.figures["ticks"], slow + wire.figures["late"]
        print(
            f"{puzzle.name}: {right} of {total} as the rules, {equal} as the twin; "
            f"{late} late commands; {slow} of {ticks} ticks of the simulated robot late",
            flush=True,
        )


if __name__ == "__main__":
    main()
