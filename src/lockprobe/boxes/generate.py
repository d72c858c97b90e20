"""Seeded generation of random boxes from recipes: interlock, layout and names."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from lockprobe.boxes.box import MAX_JOINTS, Clause, Lockbox
from lockprobe.boxes.layouts import LayoutName, laid_out
from lockprobe.boxes.state_space import fault_of, space_of
from lockprobe.boxes.structures import STRUCTURES, assemble, paper_joints
from lockprobe.foundation.errors import UnknownName
from lockprobe.foundation.seeds import generator, integer_seed
from lockprobe.foundation.validation import check_whole

_SEEDS = 2**31
_RANDOM = re.compile(r"random-([2-8])")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """The parameters of a generated box. Equal recipes give equal boxes.

    Attributes:
        family: A named box without a seed (``reset``), or ``random-N``: an interlock of N joints drawn from the seed.
        dealt: Whether kinds and names are assigned at random, and places too unless the layout is ``misleading``, so
            that they do not reveal the interlock.
        shortest: Least allowed optimum, steps, from 1.
        seed: From 0, below 2**31. Interlock and layout have separate streams.
    """

    family: str = "random-4"
    layout: LayoutName = "serial"
    dealt: bool = False
    shortest: int = 2
    seed: int = 1

    def __post_init__(self) -> None:
        if self.family not in STRUCTURES and not _RANDOM.fullmatch(self.family):
            raise UnknownName("family", self.family, [*STRUCTURES, f"random-2 to random-{MAX_JOINTS}"])
        if self.layout not in get_args(LayoutName):
            raise UnknownName("layout", self.layout, get_args(LayoutName))
        check_whole("shortest", self.shortest, 1, 2**MAX_JOINTS)
        check_whole("seed", self.seed, 0, _SEEDS - 1)

    @property
    def name(self) -> str:
        """The name of its box, for example ``reset-zigzag-7``."""
        return f"{self.family}-{self.layout}-{self.seed}"


def generate(recipe: Recipe) -> Lockbox | str:
    """The box of a recipe, or the reason why it cannot be played (:func:`fault_of`). There is only one draw."""
    drawn = _RANDOM.fullmatch(recipe.family)
    if drawn:
        box = _random_interlock(int(drawn[1]), recipe.name, generator(recipe.seed, "box", "interlock"))
    else:
        box = STRUCTURES[recipe.family]()
    box = laid_out(box, recipe.layout, generator(recipe.seed, "box", "layout"), dealt=recipe.dealt)
    return fault_of(box, recipe.shortest) or replace(box, name=recipe.name)


def random_box(joints: int, seed: int) -> Lockbox:
    """The box ``random-N-SEED``: the first of a sequence of recipes with an optimum of min(joints, 3) steps or more."""
    for attempt in range(1000):
        drawn = integer_seed(seed, "random-box", joints, attempt)
        found = generate(Recipe(family=f"random-{joints}", dealt=True, shortest=min(joints, 3), seed=drawn))
        if isinstance(found, Lockbox):
            return replace(found, name=f"random-{joints}-{seed}")
    raise AssertionError("a thousand recipes in a row give no box")


def alike_boxes(joints: int, count: int) -> tuple[Lockbox, ...]:
    """Boxes of one difficulty: the first of ``random-N-1``, ``random-N-2``, … whose shortest plan has N steps.

    So many steps takes ``chain-4``, too. Interlocks may repeat; the joints of each box are dealt anew.
    """
    found = (random_box(joints, seed) for seed in itertools.count(1))
    return tuple(itertools.islice((one for one in found if space_of(one).optimum == joints), count))


def _random_interlock(size: int, name: str, rng: np.random.Generator) -> Lockbox:
    """Joints in a line, the target first, the last one free. Clauses ask only later joints to be open.

    A joint has one or two clauses of one or two positions, of which a quarter ask for a closed joint.

    An interlock without closed positions is therefore solvable; with closed positions, moves may have to be undone, or
    the box may be unsolvable. No clause names the target.
    """
    joints = paper_joints(size)
    names = [joint for joint, _ in joints]
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
    return assemble(name, joints, interlock)
