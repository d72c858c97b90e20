"""Finds a box by name, file path or plug-in.

``chain-4`` is the default: the target (leftmost revolute) needs slider 1, slider 1 needs slider 2, slider 2
needs the right revolute, which is free. It has the four joints of the paper's box (Sec. 2.1: two prismatic in
the middle, two revolute, the leftmost is the target), but the interlock is a *reconstruction*: the real one is
not public. It is the serial chain of the only public code of this lineage, and the human-inspired strategy
meets the two points of the paper's reference curve on it (80 % by step 9, all by step 20).
"""

from __future__ import annotations

import re
from pathlib import Path

from lockprobe.boxes.box import MAX_JOINTS, Lockbox
from lockprobe.boxes.generate import random_box
from lockprobe.boxes.state_space import fault_of
from lockprobe.boxes.structures import STRUCTURES
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import allow, find_plugin, is_own_function, plugin_names
from lockprobe.foundation.spec import spec_kind, spec_name

DEFAULT_BOX = "chain-4"
_LARGEST_SEED = 10**9 - 1
_DRAWN = re.compile(r"random-([0-9]{1,12})-([0-9]{1,12})")
_EXPECTED = "a Lockbox, or a function that returns one"

ALIKE = tuple(f"random-4-{seed}" for seed in (7, 8, 18, 21, 49, 70, 72, 81))
"""Boxes of one difficulty and of different interlocks, which people play in turn: each takes four steps at best, the
human-inspired strategy 8.5 on average, and the ideal observer 8.3. Kinds and places of joints follow no interlock."""


def named_boxes() -> tuple[str, ...]:
    """The names that :func:`box` accepts, in addition to ``random-N-SEED``."""
    return tuple(STRUCTURES)


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
        from lockprobe.boxes.boxfile import read_box  # pydantic: not for a box by name

        return read_box(Path(asked))
    allow(asked)  # who asks names it: the box of a study on disk is data
    name = spec_name(asked)
    if name in STRUCTURES or _DRAWN.fullmatch(name) or (plugin := find_plugin("box", asked)) is None:
        return box(asked)
    found = plugin.make(is_one=lambda one: isinstance(one, Lockbox) or is_own_function(one), expected=_EXPECTED)
    if not isinstance(found, Lockbox):
        raise BadValue("box", asked, _EXPECTED)
    if fault := fault_of(found):
        raise BadValue("box", asked, f"one that can be played ({fault})")
    return found


def box(name: str = DEFAULT_BOX) -> Lockbox:
    """A box by name; ``random-N-SEED``, such as ``random-5-17``, has N joints and an interlock drawn from the seed."""
    if name in STRUCTURES:
        return STRUCTURES[name]()
    drawn = _DRAWN.fullmatch(name)
    if drawn is None:
        raise UnknownName("box", name, [*STRUCTURES, "random-N-SEED", *plugin_names("box")])
    joints, seed = int(drawn[1]), int(drawn[2])
    if not 2 <= joints <= MAX_JOINTS:
        raise BadValue(name, joints, f"2 to {MAX_JOINTS} joints")
    if seed > _LARGEST_SEED:
        raise BadValue(name, seed, f"a seed of at most {_LARGEST_SEED}")
    return random_box(joints, seed)
