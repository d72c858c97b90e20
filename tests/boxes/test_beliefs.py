"""Beliefs are Bayes', and plans under them the best there are: against slow enumeration, and dynamic programming without shortcuts."""

from collections import defaultdict
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest

from lockprobe.boxes.beliefs import MOST_INTERLOCKS, NEVER, PRIORS, begin, interlocks, noise_model, update
from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.planning import MOST_PLANNED, Planner, best_joints
from lockprobe.boxes.solve import optimum
from lockprobe.foundation.errors import BadValue
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


@cache
def told(needs, kind, joints, flips, states_only):
    """The reports of these attempts, and where the box was and what moved; None where it opens on the way.

    Where states alone are told, what moved is what comparing a report with the last one says.
    """
    box = as_box(needs)
    task = Task(joints=box.names, target=box.target, budget=99)
    configuration, percept, reports, truth = box.initial, Percept(positions=box.initial), [], []
    for joint, flip in zip(joints, flips, strict=True):
        configuration, moved = box.attempt(configuration, joint)
        if moved and joint == 0:
            return None
        channel = flip_of(kind, float(flip))
        real = Percept(joint=box.names[joint], outcome="moved" if moved else "blocked", positions=configuration)
        last, past = percept, (Moment(was=real, told=percept),)
        percept = channel.perceive(real, past, task, np.random.default_rng(0))
        where = None if kind == "outcome-only" else sum(p << i for i, p in enumerate(percept.positions))
        said = percept.positions[joint] != last.positions[joint] if states_only else percept.outcome == "moved"
        reports.append((joint, said, where, states_only))
        truth.append(moved)
    return tuple(reports), tuple(truth)


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
                heard := told(needs[place], kind, joints, flips, states_only)
            ):
                found[heard[0]][place, heard[1][-1]] += mass / len(kinds)
    return found


def test_a_prior_has_as_many_interlocks_as_said_and_the_distances_of_the_solver():
    assert [len(interlocks(prior, 4)) for prior in PRIORS] == [6, 142, 2152]
    for prior in PRIORS:
        for needs, distance in zip(interlocks(prior, 3).needs, interlocks(prior, 3).distance, strict=True):
            for start in range(0, 8, 2):
                there = replace(as_box(needs), initial=tuple(bool(start >> joint & 1) for joint in range(3)))
                assert distance[start] == (optimum(there) or NEVER)


def test_too_many_interlocks_are_refused_with_their_number():
    with pytest.raises(
        BadValue, match=f"prior any-literal over 5 joints: got '59049 interlocks', expected at most {MOST_INTERLOCKS}"
    ):
        interlocks("any-literal", 5)
    with pytest.raises(BadValue, match="prior single-parent over 6 joints: got '46656 interlocks'"):
        interlocks("single-parent", 6)


SMALL = interlocks("single-parent", 3)


def after(known, noise, reports):
    belief = begin(known, noise)
    for report in reports:
        belief = update(belief, *report)
    return belief


@pytest.mark.parametrize(
    ("name", "reading", "kinds", "states_only", "attempts"),
    [
        ("0.3", "memoryless", ["memoryless"], False, 2),
        ("0.3", "latched", ["latched"], False, 3),
        ("aware", "memoryless", ["outcome-only"], False, 2),
        ("aware", "integrated", ["integrated"], False, 2),
        ("aware", "positions", ["memoryless", "latched"], True, 2),
        ("aware", "outcomes", ["re-observed", "integrated"], True, 2),
    ],
)
def test_the_posterior_is_that_of_enumeration(name, reading, kinds, states_only, attempts):
    noise = noise_model(name, reading)
    for joints in [*product(range(3), repeat=attempts)][:: attempts - 1]:
        for reports, behind in histories(SMALL.needs, kinds, joints, noise.p, states_only).items():
            belief = after(SMALL, noise, reports)
            total = sum(behind.values())
            expected = [sum(behind[place, moved] for moved in (False, True)) / total for place in range(len(SMALL))]
            assert np.allclose(belief.weights, expected, atol=1e-12)
            assert belief.moved == pytest.approx(sum(m for (_, moved), m in behind.items() if moved) / total)
            assert belief.told == len(reports)


def test_a_naive_observer_begins_again_from_the_last_report():
    """Told that joint 1 moved, then that it is where it was: only the second report is kept."""
    known = interlocks("chains", 4)
    belief = after(known, noise_model("naive"), [(1, True, 2, False), (2, False, 0, False)])
    assert belief.told == 1
    assert belief.alive == after(known, noise_model("naive"), [(2, False, 0, False)]).alive


@pytest.mark.parametrize("name", ["1.5", "-0.1", "nan", "often", ""])
def test_a_noise_model_that_does_not_exist_is_refused(name):
    with pytest.raises(BadValue, match="noise: got .*, expected naive, aware, or a number from 0 to 1"):
        noise_model(name)


NAIVE = noise_model("naive")


def slow_values(known):
    """V of every set and configuration that can be met from the prior anywhere, by sweeps over all of them."""
    start = [
        (frozenset(np.flatnonzero(known.distance[:, c] < 255).tolist()), c) for c in range(0, 1 << known.joints, 2)
    ]
    ways, queue = {}, start
    while queue:
        alive, here = state = queue.pop()
        if state in ways:
            continue
        ways[state] = []
        for joint in range(known.joints):
            moved = frozenset(s for s in alive if known.masks[here][joint] >> s & 1)
            parts = [(moved, here ^ 1 << joint if joint else None), (alive - moved, here)]
            ways[state].append([(len(part) / len(alive), part, there) for part, there in parts if part])
            queue += [(part, there) for part, there in parts if part and there is not None]
    values = dict.fromkeys(ways, 0.0)
    for _ in range(100):
        values = {
            state: min(
                1 + sum(f * (values[part, there] if there is not None else 0.0) for f, part, there in way)
                for way in found
            )
            for state, found in ways.items()
        }
    return values


@pytest.mark.parametrize(("prior", "joints"), [("chains", 3), ("single-parent", 3), ("chains", 4)])
def test_planning_is_dynamic_programming(prior, joints):
    known = interlocks(prior, joints)
    fresh, slow = Planner(known), slow_values(known)
    assert len(slow) >= 12
    for (alive, here), value in slow.items():
        number = sum(1 << s for s in alive)
        assert fresh.value(number, here) == pytest.approx(value)
        assert min(fresh.values(number, here)) == pytest.approx(value)


def test_what_cannot_be_planned_is_refused_with_what_can():
    refused = f"got '720 interlocks of prior chains over 7 joints', expected at most {MOST_PLANNED} "
    with pytest.raises(BadValue, match=refused):
        best_joints(begin(interlocks("chains", 7), NAIVE))
    assert best_joints(begin(interlocks("chains", 7), noise_model("aware"))).any()
