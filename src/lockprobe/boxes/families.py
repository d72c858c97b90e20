"""The boxes by name: those of the literature, those that are drawn, and those of files and plug-ins.

The interlock of the paper's box is not public, so none of these is that box. Each starts at rest (all joints closed),
its joints in a row, the target leftmost. ``chain``, ``bichain`` and ``branched`` are those of the only public code of
its lineage (github.com/hildensia/joint_dependency: ``lockbox_serial_*``, ``lockbox_icra_2_lock_1``,
``lockbox_serial_5_with_branch``; Kulick, Otte and Toussaint, ICRA 2015; Baum et al., IROS 2017). ``common-cause`` and
``common-effect`` are the rooms of OpenLock (Edmonds et al., CogSci 2018), with levers that one attempt moves. ``fork``,
``converge``, ``reset`` and ``gray-code`` have the paper's four joints (Sec. 2.1: two prismatic in the middle, two
revolute, the leftmost is the target) and one feature each that a chain lacks.

``chain-4`` is the default, a *reconstruction*: the target needs slider 1, slider 1 needs slider 2, slider 2 needs the
right revolute, which is free. The human-inspired strategy meets the two points of the paper's reference curve on it
(80 % by step 9, all by step 20).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import count, islice, pairwise
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import MAX_JOINTS, Clause, Joint, JointKind, Lockbox
from lockprobe.boxes.layouts import LayoutName, laid_out
from lockprobe.boxes.solve import fault_of, optimum
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import allow, find_plugin, is_own_function, plugin_names
from lockprobe.foundation.seeds import generator, integer_seed
from lockprobe.foundation.spec import spec_kind

DEFAULT_BOX = "chain-4"
_SIZES = range(2, MAX_JOINTS + 1)
_RANDOM = re.compile(r"random-([2-8])")
_DRAWN = re.compile(r"random-([2-8])-([0-9]{1,9})")
_EXPECTED = "a Lockbox, or a function that returns one"

ALIKE = tuple(f"random-4-{seed}" for seed in (7, 8, 18, 21, 49, 70, 72, 81))
"""Boxes of one difficulty and of different interlocks, which people play in turn: each takes four steps at best, the
human-inspired strategy 8.5 on average, and the ideal observer 8.3. Kinds and places of joints follow no interlock."""


def _in_a_row(size: int) -> list[str]:
    """The joints of a row: revolute at both ends, sliders between."""
    return ["revolute-left", *(f"slider-{i}" for i in range(1, size - 1)), "revolute-right"]


def _assemble(name: str, joints: Sequence[str], interlock: Mapping[str, Sequence[Clause]]) -> Lockbox:
    """A box at rest with its joints in a row, the first the target; sliders and branches slide, all others turn.

    Joints without clauses are free.
    """
    kinds: list[JointKind] = ["prismatic" if joint.startswith(("slider", "branch")) else "revolute" for joint in joints]
    return Lockbox(
        name=name,
        joints=tuple(Joint(name=joint, kind=kind) for joint, kind in zip(joints, kinds, strict=True)),
        interlock={joint: tuple(clauses) for joint, clauses in interlock.items() if clauses},
        initial=(False,) * len(joints),
        target=joints[0],
    )


def _line(name: str, size: int) -> Lockbox:
    """A row of joints, each of which needs its right neighbour open, and by the name of the box more."""
    joints, interlock = _in_a_row(size), dict[str, Sequence[Clause]]()
    for i, joint in enumerate(joints):
        needs = dict.fromkeys(joints[i + 1 : i + 2], True)
        if name == "bichain":
            needs |= dict.fromkeys(joints[max(i - 1, 0) : i], False)
        elif name == "gray-code":
            needs |= dict.fromkeys(joints[i + 2 :], False)
        interlock[joint] = [needs] if needs else []
    return _assemble(f"{name}-{size}", joints, interlock)


def _room(name: str, levers: int) -> Lockbox:
    """A door and levers, of which the first is the common cause of the others, or their common effect."""
    names = ["door", *(f"lever-{i}" for i in range(levers))]
    first: list[Clause] = [{"lever-0": True}]
    others: list[Clause] = [{lever: True} for lever in names[2:]]
    cause = {"door": others, **dict.fromkeys(names[2:], first)}
    return _assemble(f"{name}-{levers}", names, cause if name == "common-cause" else {"door": first, "lever-0": others})


_BRANCHED = ["revolute-left", "slider-3", "slider-2", "slider-1", "revolute-right", "branch-1", "branch-2"]

_OTHERS: Mapping[str, tuple[Sequence[str], Mapping[str, Clause]]] = {
    "fork": (_in_a_row(4), {"revolute-left": {"slider-2": True, "slider-1": True}}),
    "converge": (
        _in_a_row(4),
        {"revolute-left": {"slider-1": True}, "slider-1": {"revolute-right": True, "slider-2": True}},
    ),
    "reset": (
        _in_a_row(4),
        {
            "slider-2": {"revolute-right": True},
            "slider-1": {"slider-2": True},
            "revolute-left": {"slider-1": True, "revolute-right": False},
        },
    ),
    "branched": (  # a chain of five; an open slider-2 locks branch-1, and branch-2 needs branch-1 open
        _BRANCHED,
        {joint: {right: True} for joint, right in pairwise(_BRANCHED[:5])}
        | {"branch-1": {"slider-2": False}, "branch-2": {"branch-1": True}},
    ),
}
"""Boxes each of whose joints is free or has one clause."""

STRUCTURES: Mapping[str, Lockbox] = {
    **{f"{name}-{n}": _line(name, n) for name in ("chain", "bichain", "gray-code") for n in _SIZES},
    "gray-code": replace(_line("gray-code", 4), name="gray-code"),
    **{
        name: _assemble(name, joints, {joint: [clause] for joint, clause in needs.items()})
        for name, (joints, needs) in _OTHERS.items()
    },
    **{f"{name}-{n}": _room(name, n) for name in ("common-cause", "common-effect") for n in (3, 4)},
}
"""Box by name."""


def generate(
    family: str, seed: int = 1, *, layout: LayoutName = "serial", dealt: bool = False, shortest: int = 2
) -> Lockbox | str:
    """A generated box, for example ``reset-zigzag-7``, or why it cannot be played (:func:`fault_of`).

    There is only one draw. Interlock and layout have separate streams.

    Args:
        family: A named box without a seed (``reset``), or ``random-N``: an interlock of N joints drawn from the seed.
        seed: From 0.
        layout: Where the joints lie on the panel.
        dealt: Whether kinds and names are assigned at random, and places too unless the layout is ``misleading``, so
            that they do not reveal the interlock.
        shortest: Least allowed optimum, steps, from 1.
    """
    drawn = _RANDOM.fullmatch(family)
    if family not in STRUCTURES and not drawn:
        raise UnknownName("family", family, [*STRUCTURES, f"random-2 to random-{MAX_JOINTS}"])
    name = f"{family}-{layout}-{seed}"
    box = _random_interlock(int(drawn[1]), name, generator(seed, "box", "interlock")) if drawn else STRUCTURES[family]
    box = laid_out(box, layout, generator(seed, "box", "layout"), dealt=dealt)
    return fault_of(box, shortest) or replace(box, name=name)


def random_box(joints: int, seed: int) -> Lockbox:
    """The box ``random-N-SEED``: the first that is generated with an optimum of min(joints, 3) steps or more."""
    for attempt in range(1000):
        drawn = integer_seed(seed, "random-box", joints, attempt)
        found = generate(f"random-{joints}", drawn, dealt=True, shortest=min(joints, 3))
        if isinstance(found, Lockbox):
            return replace(found, name=f"random-{joints}-{seed}")
    raise AssertionError("a thousand draws in a row give no box")


def alike_boxes(joints: int, many: int) -> tuple[Lockbox, ...]:
    """Boxes of one difficulty: the first of ``random-N-1``, ``random-N-2``, … whose shortest plan has N steps.

    So many steps takes ``chain-4``, too. Interlocks may repeat; the joints of each box are dealt anew.
    """
    found = (random_box(joints, seed) for seed in count(1))
    return tuple(islice((one for one in found if optimum(one) == joints), many))


def _random_interlock(size: int, name: str, rng: np.random.Generator) -> Lockbox:
    """Joints in a line, the target first, the last one free. Clauses ask only later joints to be open.

    A joint has one or two clauses of one or two positions, of which a quarter ask for a closed joint.

    An interlock without closed positions is therefore solvable; with closed positions, moves may have to be undone, or
    the box may be unsolvable. No clause names the target.
    """
    names = _in_a_row(size)
    interlock: dict[str, Sequence[Clause]] = {}
    for i, joint in enumerate(names[:-1]):
        clauses = []
        for _ in range(1 + int(rng.random() * 2)):
            clause: dict[str, bool] = {}
            for _ in range(1 + int(rng.random() * 2)):
                position = bool(rng.random() >= 0.25)
                others = names[i + 1 :] if position else [other for other in names[1:] if other != joint]
                if free := [other for other in others if other not in clause]:  # near joints more often, for depth
                    clause[free[int(rng.random() ** 2 * len(free))]] = position
            clauses.append(clause)
        kept: list[Clause] = []  # without those that a weaker one makes superfluous
        for one in sorted(clauses, key=len):
            if not any(weaker.items() <= one.items() for weaker in kept):
                kept.append(one)
        alone = {item for one in kept if len(one) == 1 for item in one.items()}
        interlock[joint] = [] if any((other, not position) in alone for other, position in alone) else kept  # free
    return _assemble(name, names, interlock)


def box(name: str = DEFAULT_BOX) -> Lockbox:
    """One of Lockprobe's own boxes; ``random-N-SEED``, as ``random-5-17``, has N joints and a drawn interlock."""
    if name in STRUCTURES:
        return STRUCTURES[name]
    if (drawn := _DRAWN.fullmatch(name)) is None:
        drawn_too = f"random-N-SEED with N from 2 to {MAX_JOINTS} and at most nine digits of SEED"
        raise UnknownName("box", name, [*STRUCTURES, drawn_too, *plugin_names("box")])
    return random_box(int(drawn[1]), int(drawn[2]))


def find_box(asked: str | Path | Lockbox = DEFAULT_BOX) -> Lockbox:
    """A box from a name, the path of a TOML file, or a :class:`Lockbox`.

    Besides the names of :func:`box` there are those of installed packages (entry points in the group
    ``lockprobe.boxes``) and ``python:module:Name?option=value``: a :class:`Lockbox`, or a function that returns one.
    What cannot be found or played is a ``UserMistake``.
    """
    if isinstance(asked, Lockbox):
        return asked
    if not isinstance(asked, str | Path):
        raise BadValue("box", asked, "a name, a Lockbox or the path of a TOML file")
    if str(asked).lower().endswith((".xml", ".mjcf")):
        plant = f"--plant 'twin?model={asked}' plays it, and lockprobe box check FILE.toml {asked} compares the two"
        raise BadValue("box", str(asked), f"a name or FILE.toml with its rules; a MuJoCo model is a plant: {plant}")
    if isinstance(asked, Path) or (spec_kind(asked) != "python" and (asked.endswith(".toml") or "/" in asked)):
        from lockprobe.boxes.boxfile import read_box  # whose schema a box by name does not need

        return read_box(Path(asked))
    allow(asked)  # who asks names it: the box of a study on disk is data
    if asked in STRUCTURES or _DRAWN.fullmatch(asked) or (plugin := find_plugin("box", asked)) is None:
        return box(asked)
    found = plugin.make(is_one=lambda one: isinstance(one, Lockbox) or is_own_function(one), expected=_EXPECTED)
    if not isinstance(found, Lockbox):
        raise BadValue("box", asked, _EXPECTED)
    if fault := fault_of(found):
        raise BadValue("box", asked, f"one that can be played ({fault})")
    return found
