"""Bayes the slow way: every interlock, every pattern of flips, told by the real channel."""

from collections import defaultdict
from functools import cache
from itertools import product

import numpy as np

from lockprobe.boxes.beliefs.posterior import ReportedAttempt
from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.interventions.flip import flip_of
from lockprobe.trial.record import Moment, Percept, Task

NODES, MASS = np.polynomial.legendre.leggauss(12)
NODES, MASS = (NODES + 1) / 2, MASS / 2


def as_box(needs):
    """A prior's interlock as a box."""
    names = [f"j{i}" for i in range(len(needs))]
    interlock = {names[i]: ({names[need[0]]: bool(need[1])},) for i, need in enumerate(needs) if need}
    joints = tuple(Joint(name=name, kind="revolute") for name in names)
    return Lockbox(name="x", joints=joints, interlock=interlock, initial=(False,) * len(names), target="j0")


def told(box, kind, joints, flips, states_only=False):
    """The reports of these attempts, and where the box was and what moved; None where it opens on the way.

    Where states alone are told, what moved is what comparing a report with the last one says.
    """
    task = Task(joints=box.names, target=box.target, budget=99)
    configuration, percept, reports, truth = box.initial, Percept(positions=box.initial), [], []
    for joint, flip in zip(joints, flips, strict=True):
        configuration, moved = box.attempt(configuration, joint)
        if moved and joint == 0:
            return None
        channel = flip_of(kind, float(flip))
        real = Percept(joint=box.names[joint], outcome="moved" if moved else "blocked", positions=configuration)
        last, percept = (
            percept,
            channel.perceive(real, (Moment(was=real, told=percept),), task, np.random.default_rng(0)),
        )
        where = None if kind == "outcome-only" else sum(p << i for i, p in enumerate(percept.positions))
        said = percept.positions[joint] != last.positions[joint] if states_only else percept.outcome == "moved"
        reports.append(ReportedAttempt(joint, said, where, states_only))
        truth.append(moved)
    return tuple(reports), tuple(truth)


@cache
def _told_under(needs, kind, joints, flips, states_only):
    return told(as_box(needs), kind, joints, flips, states_only)


def likelihood(p, false, of):
    """Of one pattern with so many false reports; p None is equal density over [0, 1], by quadrature."""
    if p is None:
        return float(MASS @ (NODES**false * (1 - NODES) ** (of - false)))
    return p**false * (1 - p) ** (of - false)


def histories(needs, kinds, joints, p, states_only=False):
    """Every told history of these attempts, with the mass of (interlock, what moved last) behind it."""
    found = defaultdict(lambda: defaultdict(float))
    for place, kind in product(range(len(needs)), kinds):
        for flips in product([False, True], repeat=len(joints)):
            if (mass := likelihood(p, sum(flips), len(flips))) and (
                heard := _told_under(needs[place], kind, joints, flips, states_only)
            ):
                found[heard[0]][place, heard[1][-1]] += mass / len(kinds)
    return found
