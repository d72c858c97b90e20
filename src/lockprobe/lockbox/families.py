"""Named boxes.

``chain-4`` is the default: the target (leftmost revolute) needs slider 1, slider 1 needs slider 2, slider 2
needs the right revolute, which is free. It has the four joints of the paper's box (Sec. 2.1: two prismatic in
the middle, two revolute, the leftmost is the target), but the interlock is a *reconstruction*: the real one is
not public. It is the serial chain of the only public code of this lineage, and the human-inspired strategy
reproduces the paper's reference curve on it (80 % by step 9, all by step 20).
"""

from __future__ import annotations

import re

from lockprobe.errors import BadValue, UnknownName
from lockprobe.lockbox.box import Joint, Lockbox

__all__ = ["DEFAULT_BOX", "box", "chain", "named_boxes"]

DEFAULT_BOX = "chain-4"
CHAIN_SIZES = range(2, 9)


def chain(size: int) -> Lockbox:
    """A serial chain: every joint needs its right neighbour open; the rightmost is free.

    Args:
        size: Number of joints, 2 to 8. The optimum is ``size`` steps.
    """
    if size not in CHAIN_SIZES:
        raise BadValue("chain", size, f"{CHAIN_SIZES.start} to {CHAIN_SIZES.stop - 1} joints")
    names = ["revolute-left", *(f"slider-{i}" for i in range(1, size - 1)), "revolute-right"]
    joints = tuple(
        Joint(
            name=name,
            kind="revolute" if name.startswith("revolute") else "prismatic",
            place=(round((i + 0.5) / size, 3), 0.5),
        )
        for i, name in enumerate(names)
    )
    return Lockbox(
        name=f"chain-{size}",
        joints=joints,
        interlock={name: ({names[i + 1]: True},) for i, name in enumerate(names[:-1])},
        initial=(False,) * size,
        target=names[0],
    )


def named_boxes() -> tuple[str, ...]:
    """Names that :func:`box` knows."""
    return tuple(f"chain-{size}" for size in CHAIN_SIZES)


def box(name: str = DEFAULT_BOX) -> Lockbox:
    """A box by name.

    Raises:
        UnknownName: If there is no such box; the message lists those that exist.

    >>> box("chain-4").target
    'revolute-left'
    """
    found = re.fullmatch(r"chain-(\d+)", name)
    if found is None or name not in named_boxes():
        raise UnknownName("box", name, named_boxes())
    return chain(int(found[1]))
