"""Boxes by name.

``chain-4`` is the default: the target (leftmost revolute) needs slider 1, slider 1 needs slider 2, slider 2
needs the right revolute, which is free. It has the four joints of the paper's box (Sec. 2.1: two prismatic in
the middle, two revolute, the leftmost is the target), but the interlock is a *reconstruction*: the real one is
not public. It is the serial chain of the only public code of this lineage, and the human-inspired strategy
reproduces the paper's reference curve on it (80 % by step 9, all by step 20).
"""

from __future__ import annotations

import re
from pathlib import Path

from lockprobe.errors import BadValue, UnknownName
from lockprobe.lockbox.box import MAX_JOINTS, Lockbox
from lockprobe.lockbox.generate import random_box
from lockprobe.lockbox.structures import STRUCTURES

__all__ = ["DEFAULT_BOX", "box", "find_box", "named_boxes", "sized"]

DEFAULT_BOX = "chain-4"
_LARGEST_SEED = 10**9 - 1


def named_boxes() -> tuple[str, ...]:
    """Names that :func:`box` knows, beside ``random-N-SEED``."""
    return tuple(STRUCTURES)


def sized(family: str, joints: int | None) -> str:
    """The full name of a family with so many joints, for example ``chain-5`` for ``chain`` and 5.

    Args:
        family: With its number or without, or ``random``.
        joints: How many joints its boxes have; None is 4, or what the name says.

    Raises:
        BadValue: If the family has no box of that size; the message lists the sizes that it has.
    """
    known = {name: len(STRUCTURES[name]().joints) for name in STRUCTURES}
    known |= {f"random-{n}": n for n in range(2, MAX_JOINTS + 1)}
    if family in known and joints in (None, known[family]):
        return family
    sizes = {n: name for name, n in known.items() if family in (name, name.rpartition("-")[0])}
    if sizes and (joints or 4) not in sizes:
        raise BadValue(f"joints of {family}", joints or 4, f"one of {', '.join(map(str, sorted(sizes)))}")
    return sizes.get(joints or 4, family)


def find_box(name: str) -> Lockbox:
    """A box by name, or from a TOML file by path.

    Raises:
        UnknownName: If there is no box of the name.
        BadFile: If the file holds none that can be played.
    """
    if not name.endswith(".toml") and "/" not in name:
        return box(name)
    from lockprobe.lockbox.boxfile import read_box  # pydantic: not for a box by name

    return read_box(Path(name))


def box(name: str = DEFAULT_BOX) -> Lockbox:
    """A box by name. ``random-N-SEED``, for example ``random-5-17``, has N joints and an interlock drawn from the seed.

    Raises:
        UnknownName: If there is no such box; the message lists those that exist.
        BadValue: If ``random-N-SEED`` has a number out of range.

    >>> box("chain-4").target
    'revolute-left'
    """
    if name in STRUCTURES:
        return STRUCTURES[name]()
    drawn = re.fullmatch(r"random-([0-9]{1,12})-([0-9]{1,12})", name)
    if drawn is None:
        raise UnknownName("box", name, [*STRUCTURES, "random-N-SEED"])
    joints, seed = int(drawn[1]), int(drawn[2])
    if not 2 <= joints <= MAX_JOINTS:
        raise BadValue(name, joints, f"2 to {MAX_JOINTS} joints")
    if seed > _LARGEST_SEED:
        raise BadValue(name, seed, f"a seed of at most {_LARGEST_SEED}")
    return random_box(joints, seed)
