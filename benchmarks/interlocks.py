"""Random interlocks built of pins and blocks, their joints pushed at random, against the symbolic rule.

    python benchmarks/interlocks.py [--interlocks 20] [--pushes 200] [--newtons 10,30,60,100] [--seed 1]

A leak is a locked joint that moved, a jam a free one that did not get to its other end. A neighbour moved if it is not
where it was. The wiggle is the furthest that a locked joint gives way, as a fraction of its travel.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

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

    def __init__(self, scene: LockboxScene) -> None:
        super().__init__(scene)
        self.rested = self.fractions()
        self.strayed = np.zeros(len(self.rested))

    def step(self) -> None:
        """One step."""
        super().step()
        self.strayed = np.maximum(self.strayed, np.abs(self.fractions() - self.rested))

    def rest(self) -> None:
        """Forget."""
        self.rested = np.array(self.configuration(), dtype=float)
        self.strayed[:] = 0


@dataclass
class Tally:
    """What was counted."""

    pushes: int = 0
    locked: int = 0
    leaks: int = 0
    jams: int = 0
    neighbours: int = 0
    wiggles: list[float] = field(default_factory=list)
    steps: float = 0
    seconds: float = 0


def pushed(box: Lockbox, pushes: int, newtons: float, rng: np.random.Generator, tally: Tally) -> None:
    """Push the joints of one box at random, from random configurations."""
    size = len(box.joints)
    mechanism = Watched(build_scene(box, labels=box.names, settings=SceneSettings(), rng=rng))
    model, data = mechanism.model, mechanism.data
    mechanism.set_configuration(box.initial)
    for number in range(pushes):
        if number % 10 == 9:
            mechanism.set_configuration(tuple(bool(x) for x in rng.integers(0, 2, size)))
        before, joint = mechanism.configuration(), int(rng.integers(size))
        mechanism.rest()
        since, clock = data.time, time.perf_counter()
        mechanism.push(joint, newtons)
        tally.seconds += time.perf_counter() - clock
        moved = mechanism.configuration()[joint] != before[joint]
        tally.steps += (data.time - since) / model.opt.timestep
        _, should = box.attempt(before, joint)
        end = np.abs(mechanism.fractions() - (not before[joint]))[joint]
        others = np.delete(mechanism.strayed, joint)
        tally.pushes += 1
        tally.locked += not should
        tally.leaks += moved and not should
        tally.jams += should and (not moved or end > RESTING)
        tally.neighbours += bool((others > RESTING).any())
        if not should:
            tally.wiggles.append(float(mechanism.strayed[joint]))
        if mechanism.configuration() != box.attempt(before, joint)[0] or not mechanism.resting():
            mechanism.set_configuration(box.attempt(before, joint)[0])


def buildable(count: int, seed: int) -> Iterator[Lockbox]:
    """So many interlocks that can be built; says of the others why not."""
    number, found = 0, 0
    while found < count:
        box = random_interlock(number, np.random.default_rng([seed, number]))
        number += 1
        try:
            build_scene(
                box, labels=tuple("ABCDEFGH"[: len(box.joints)]), settings=SceneSettings(), rng=np.random.default_rng(0)
            )
        except BadValue as refusal:
            print(f"{box.name} with {len(box.joints)} joints is refused: {refusal}")
            continue
        found += 1
        yield box


def main() -> None:
    """Print a table, one line for each force."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interlocks", type=int, default=20)
    parser.add_argument("--pushes", type=int, default=200)
    parser.add_argument("--newtons", default="10,30,60,100")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    boxes = list(buildable(asked.interlocks, asked.seed))
    kinds: Counter[str] = Counter()
    alternatives = 0
    for box in boxes:
        for gate in build_scene(
            box, labels=tuple("ABCDEFGH"[: len(box.joints)]), settings=SceneSettings(), rng=np.random.default_rng(0)
        ).gates:
            alternatives += len(gate.literals) > 1
            for other, _ in gate.literals:
                kinds[f"{box.joints[gate.joint].kind} <- {box.joints[other].kind}"] += 1
    pairs = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    print(f"{len(boxes)} interlocks; {pairs}; {alternatives} gates with alternatives")
    print("newtons  pushes  locked  leaks  jams  neighbours  wiggle mean  max   ms/push  us/step")
    for newtons in (float(part) for part in asked.newtons.split(",")):
        tally = Tally()
        for number, box in enumerate(boxes):
            pushed(box, asked.pushes, newtons, np.random.default_rng([asked.seed, number, 1]), tally)
        row = [f"{newtons:7.0f}"]
        row += [f"{n:7d}" for n in (tally.pushes, tally.locked)]
        row += [f"{tally.leaks:6d}", f"{tally.jams:5d}", f"{tally.neighbours:11d}"]
        row += [f"{np.mean(tally.wiggles):12.4f}", f"{max(tally.wiggles):6.4f}"]
        row += [f"{1000 * tally.seconds / tally.pushes:8.2f}", f"{1e6 * tally.seconds / tally.steps:8.1f}"]
        print(" ".join(row))


if __name__ == "__main__":
    main()
