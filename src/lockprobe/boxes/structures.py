"""The named boxes and their interlocks.

Each starts at rest (all joints closed), its joints in a row, the target leftmost.

The interlock of the paper's box is not public, so none of these is that box. ``chain``, ``bichain`` and ``branched``
are those of the only public code of its lineage (github.com/hildensia/joint_dependency: ``lockbox_serial_*``,
``lockbox_icra_2_lock_1``, ``lockbox_serial_5_with_branch``; Kulick, Otte and Toussaint, ICRA 2015; Baum et al.,
IROS 2017). ``common-cause`` and ``common-effect`` are the rooms of OpenLock (Edmonds et al., CogSci 2018), with levers
that one attempt moves. ``fork``, ``converge``, ``reset`` and ``gray-code`` have the paper's four joints (Sec. 2.1: two
prismatic in the middle, two revolute, the leftmost is the target) and one feature each that a chain lacks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise

from lockprobe.boxes.box import MAX_JOINTS, Clause, Joint, JointKind, Lockbox

SIZES = range(2, MAX_JOINTS + 1)


def paper_joints(size: int) -> list[tuple[str, JointKind]]:
    """Names and kinds in a row: revolute at both ends, sliders between."""
    sliders: list[tuple[str, JointKind]] = [(f"slider-{i}", "prismatic") for i in range(1, size - 1)]
    return [("revolute-left", "revolute"), *sliders, ("revolute-right", "revolute")]


def assemble(name: str, joints: Sequence[tuple[str, JointKind]], interlock: Mapping[str, Sequence[Clause]]) -> Lockbox:
    """A box at rest with its joints in a row, the first the target; joints without clauses are free."""
    return Lockbox(
        name=name,
        joints=tuple(
            Joint(name=joint, kind=kind, place=(round((i + 0.5) / len(joints), 3), 0.5))
            for i, (joint, kind) in enumerate(joints)
        ),
        interlock={joint: tuple(clauses) for joint, clauses in interlock.items() if clauses},
        initial=(False,) * len(joints),
        target=joints[0][0],
    )


def _chain(size: int) -> Lockbox:
    joints = paper_joints(size)
    return assemble(f"chain-{size}", joints, {j: [{right: True}] for (j, _), (right, _) in pairwise(joints)})


def _bichain(size: int) -> Lockbox:
    joints = paper_joints(size)
    needs: dict[str, dict[str, bool]] = {j: {right: True} for (j, _), (right, _) in pairwise(joints)}
    for (dependant, _), (joint, _) in pairwise(joints):
        needs[joint] = needs.get(joint, {}) | {dependant: False}
    return assemble(f"bichain-{size}", joints, {j: [clause] for j, clause in needs.items()})


def _gray_code(size: int, name: str) -> Lockbox:
    joints = [joint for joint, _ in paper_joints(size)]
    interlock = {
        joint: [{joints[i + 1]: True, **dict.fromkeys(joints[i + 2 :], False)}] for i, joint in enumerate(joints[:-1])
    }
    return assemble(name, paper_joints(size), interlock)


def _room(name: str, levers: int) -> Lockbox:
    """A door and levers, of which the first is the common cause of the others, or their common effect."""
    names = ["door", *(f"lever-{i}" for i in range(levers))]
    first: list[Clause] = [{"lever-0": True}]
    others: list[Clause] = [{lever: True} for lever in names[2:]]
    cause = {"door": others, **dict.fromkeys(names[2:], first)}
    interlock = cause if name == "common-cause" else {"door": first, "lever-0": others}
    return assemble(f"{name}-{levers}", [(joint, "revolute") for joint in names], interlock)


def _branched() -> Lockbox:
    """A chain of five; an open slider-2 locks branch-1, and branch-2 needs branch-1 open."""
    joints: list[tuple[str, JointKind]] = [
        ("revolute-left", "revolute"),
        *((f"slider-{i}", "prismatic") for i in (3, 2, 1)),
        ("revolute-right", "revolute"),
        ("branch-1", "prismatic"),
        ("branch-2", "prismatic"),
    ]
    interlock: dict[str, list[Clause]] = {j: [{right: True}] for (j, _), (right, _) in pairwise(joints[:5])}
    interlock |= {"branch-1": [{"slider-2": False}], "branch-2": [{"branch-1": True}]}
    return assemble("branched", joints, interlock)


_FOUR: Mapping[str, Mapping[str, Clause]] = {
    "fork": {"revolute-left": {"slider-2": True, "slider-1": True}},
    "converge": {"revolute-left": {"slider-1": True}, "slider-1": {"revolute-right": True, "slider-2": True}},
    "reset": {
        "slider-2": {"revolute-right": True},
        "slider-1": {"slider-2": True},
        "revolute-left": {"slider-1": True, "revolute-right": False},
    },
}
"""Boxes of the paper's joints, each of which is free or has one clause."""

STRUCTURES: Mapping[str, Callable[[], Lockbox]] = {
    **{f"chain-{n}": partial(_chain, n) for n in SIZES},
    **{f"bichain-{n}": partial(_bichain, n) for n in SIZES},
    **{
        name: partial(assemble, name, paper_joints(4), {joint: [clause] for joint, clause in clauses.items()})
        for name, clauses in _FOUR.items()
    },
    "gray-code": partial(_gray_code, 4, "gray-code"),
    **{f"gray-code-{n}": partial(_gray_code, n, f"gray-code-{n}") for n in SIZES},
    **{f"{name}-{n}": partial(_room, name, n) for name in ("common-cause", "common-effect") for n in (3, 4)},
    "branched": _branched,
}
"""Box by name."""
