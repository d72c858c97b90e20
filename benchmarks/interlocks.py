"""Random interlocks built of pins and blocks, their joints pushed at random, against the symbolic rule.

    python benchmarks/interlocks.py [--interlocks 20] [--pushes 200] [--newtons 10,30,60,100] [--seed 1]

A leak is a locked joint that moved, a jam a free one that did not get to its other end. A neighbour moved if it is not
where it was. The wiggle is the furthest that a locked joint gives way, as a fraction of its travel.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
from lockprobe_robot.box_model.joints import RESTING
from lockprobe_robot.box_model.mechanism import Mechanism
from lockprobe_robot.box_model.scene import LockboxScene, build_scene
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.box import Joint, JointKind, Lockbox
from lockprobe.boxes.layouts import LayoutName, places
from lockprobe.foundation.errors import BadValue

LAYOUTS: tuple[LayoutName, ...] = ("serial", "zigzag", "ngram", "grid", "scattered")
KINDS: tuple[JointKind, ...] = ("prismatic", "revolute")


def random_interlock(number: int, rng: np.random.Generator) -> Lockbox:
    """A box of 3 to 8 joints with up to three clauses of up to three literals each; it need not be solvable."""
    size = 3 + number % 6
    names = [f"joint-{i}" for i in range(size)]
    spots = places(LAYOUTS[number % len(LAYOUTS)], size, rng)
    interlock = {}
    for name in names:
        others = [other for other in names if other != name]
        clauses = []
        for _ in range(int(rng.integers(0, 4))):
            asked = rng.permutation(others)[: int(rng.integers(1, min(3, len(others)) + 1))]
            clauses.append({str(other): bool(rng.random() < 0.6) for other in asked})
        if clauses:
            interlock[name] = tuple(clauses)
    return Lockbox(
        name=f"interlock-{number}",
        joints=tuple(
            Joint(name=name, kind=KINDS[int(rng.integers(2))], place=place)
            for name, place in zip(names, spots, strict=True)
        ),
        interlock=interlock,
        initial=tuple(bool(x) for x in rng.integers(0, 2, size)),
        target=names[0],
    )


class Watched(Mechanism):
    """A mechanism that remembers how far its joints have been from where they rested."""

    rested = strayed = 0.0

    def step(self) -> None:
        """One step."""
        super().step()
        self.strayed = np.maximum(self.strayed, np.abs(self.fractions() - self.rested))

    def rest(self) -> None:
        """Forget."""
        self.rested, self.strayed = np.array(self.configuration(), dtype=float), np.zeros(len(self.names))


def pushed(box: Lockbox, pushes: int, newtons: float, rng: np.random.Generator) -> np.ndarray:
    """Push the joints of one box at random, from random configurations; a row a push, as ``COUNTED`` says."""
    scene = build_scene(box, labels=box.names, settings=SceneSettings(), rng=rng)
    mechanism, size, rows = Watched(scene), len(box.joints), []
    mechanism.set_configuration(box.initial)
    for number in range(pushes):
        if number % 10 == 9:
            mechanism.set_configuration(tuple(bool(x) for x in rng.integers(0, 2, size)))
        before, joint = mechanism.configuration(), int(rng.integers(size))
        mechanism.rest()
        since, clock = mechanism.data.time, time.perf_counter()
        mechanism.push(joint, newtons)
        seconds, steps = time.perf_counter() - clock, (mechanism.data.time - since) / mechanism.model.opt.timestep
        found, (after, free) = mechanism.configuration(), box.attempt(before, joint)
        moved, end = found[joint] != before[joint], abs(mechanism.fractions()[joint] - (not before[joint]))
        jam, strayed = free and (not moved or end > RESTING), mechanism.strayed
        neighbour, wiggle = (np.delete(strayed, joint) > RESTING).any(), 0.0 if free else strayed[joint]
        rows.append((1, not free, moved and not free, jam, neighbour, wiggle, steps, seconds))
        if found != after or not mechanism.resting():
            mechanism.set_configuration(after)
    return np.array(rows, dtype=float)


COUNTED = ("pushes", "locked", "leaks", "jams", "neighbours", "wiggle", "steps", "seconds")


def buildable(count: int, seed: int) -> Iterator[tuple[Lockbox, LockboxScene]]:
    """So many interlocks that can be built; says of the others why not."""
    found = 0
    for number in itertools.count():
        if found == count:
            return
        box = random_interlock(number, np.random.default_rng([seed, number]))
        try:
            yield box, build_scene(box, labels=box.names, settings=SceneSettings(), rng=np.random.default_rng(0))
            found += 1
        except BadValue as refusal:
            print(f"{box.name} with {len(box.joints)} joints is refused: {refusal}")


def main() -> None:
    """Print a table, one line for each force."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interlocks", type=int, default=20)
    parser.add_argument("--pushes", type=int, default=200)
    parser.add_argument("--newtons", default="10,30,60,100")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    boxes = list(buildable(asked.interlocks, asked.seed))
    gates = [(box, gate) for box, scene in boxes for gate in scene.gates]
    joints = [(box.joints[gate.joint], box.joints[other]) for box, gate in gates for other, _ in gate.literals]
    kinds = Counter(f"{locked.kind} <- {other.kind}" for locked, other in joints)
    pairs = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    alternatives = sum(len(gate.literals) > 1 for _, gate in gates)
    print(f"{len(boxes)} interlocks; {pairs}; {alternatives} gates with alternatives")
    print("newtons  pushes  locked  leaks  jams  neighbours  wiggle mean  max   ms/push  us/step")
    for newtons in map(float, asked.newtons.split(",")):
        streams = [np.random.default_rng([asked.seed, number, 1]) for number in range(len(boxes))]
        rows = [pushed(box, asked.pushes, newtons, rng) for (box, _), rng in zip(boxes, streams, strict=True)]
        found = dict(zip(COUNTED, np.concatenate(rows).T, strict=True))
        pushes, locked, leaks, jams, neighbours, wiggle, steps, seconds = (one.sum() for one in found.values())
        print(
            f"{newtons:7.0f} {pushes:7.0f} {locked:7.0f} {leaks:6.0f} {jams:5.0f} {neighbours:11.0f} "
            f"{wiggle / locked:12.4f} {found['wiggle'].max():6.4f} "
            f"{1000 * seconds / pushes:8.2f} {1e6 * seconds / steps:8.1f}"
        )


if __name__ == "__main__":
    main()
