"""Exact reference curves of a box: random agents and the shortest plan."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.solve import optimum, random_curve


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Exact success curves of random agents, and the length of the shortest plan.

    Attributes:
        random: Share solved by step 0, 1, ... up to the budget by a uniformly random agent.
        no_repeat: The same for a random agent that never attempts a joint twice in a row.
        optimum: The fewest steps that solve the box; None if nothing does.
    """

    random: tuple[float, ...]
    no_repeat: tuple[float, ...]
    optimum: int | None


def reference_of(box: Lockbox, budget: int) -> Reference:
    """The references of a box to this budget, in steps."""
    return Reference(
        random=random_curve(box, budget), no_repeat=random_curve(box, budget, repeats=False), optimum=optimum(box)
    )
