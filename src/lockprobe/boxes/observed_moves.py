"""Rules from observed attempts: which clauses agree with the moves that a physical box made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Clause, Configuration, Lockbox

__all__ = ["Push", "corrected", "fitting_clauses"]

_CLAUSE, _OPEN, _CLOSED = 16.0, 1.0, 1.01
"""Costs of a new clause and of its positions. A clause of the box costs 1, so that little changes."""


_Cube = tuple[int | None, ...]
"""A clause as the position of every other joint; None where any will do."""

_COST = {None: 0.0, 1: _OPEN, 0: _CLOSED}


@dataclass(frozen=True, slots=True, kw_only=True)
class Push:
    """One attempt at a joint of a physical box, and what the rules say of it.

    Attributes:
        configuration: The configuration before.
        joint: By index in panel order.
        allowed: Whether the rules let the joint move.
        moved: Whether it moved; None if something happened that no rule can say.
        disagreement: The difference between rules and box in words; empty if they agree.
    """

    configuration: Configuration
    joint: int
    allowed: bool
    moved: bool | None
    disagreement: str = ""


def corrected(box: Lockbox, pushes: Iterable[Push]) -> tuple[Lockbox, dict[str, str]]:
    """The box with new clauses for every joint whose moves contradict the rules.

    Returns:
        The box, and for each joint whose moves no clauses describe the reason in words.
    """
    seen: dict[int, dict[Configuration, bool]] = {}
    wrong = set()
    for push in pushes:
        if push.moved is not None:
            seen.setdefault(push.joint, {})[push.configuration] = push.moved
            if push.moved != push.allowed:
                wrong.add(push.joint)
    interlock, left = dict(box.interlock), {}
    for joint in sorted(wrong):
        name = box.names[joint]
        clauses = fitting_clauses(box, joint, seen[joint])
        if clauses:
            interlock[name] = clauses
        else:
            left[name] = "never moved" if clauses == () else "moved one way and not back"
    return replace(box, interlock=interlock), left


def fitting_clauses(box: Lockbox, joint: int, seen: Mapping[Configuration, bool]) -> tuple[Clause, ...] | None:
    """The simplest clauses that hold where a joint moved and do not hold where it was held.

    Of all such sets it is one with the fewest new clauses, and of those one with the fewest positions. Clauses of the
    box that fit are kept if they are needed. In configurations that were not seen, the clauses may say either.

    Args:
        box: The box.
        joint: By index in panel order.
        seen: Configuration -> whether the joint moved there. Only the positions of other joints count.

    Returns:
        No clause if the joint never moved; one empty clause if it moved everywhere; None if it moved at one of its own
        positions and was held at the other, with all other joints in the same positions: no clauses say that.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp

    configurations, moved = np.array(list(seen)), np.array(list(seen.values()), bool)
    if not moved.any():
        return ()
    others = [i for i in range(len(box.names)) if i != joint]
    candidates: dict[_Cube, NDArray[np.bool_]] = {}
    for cube in product((None, 1, 0), repeat=len(others)):
        holds = np.ones(len(moved), bool)
        for other, position in zip(others, cube, strict=True):
            if position is not None:
                holds &= configurations[:, other] == position
        if holds.any() and not (holds & ~moved).any():
            candidates[cube] = holds
    own = {tuple(_position(clause, box.names[i]) for i in others) for clause in box.interlock.get(box.names[joint], ())}
    if not all(any(holds[i] for holds in candidates.values()) for i in np.flatnonzero(moved)):
        return None
    kept = [cube for cube in candidates if cube in own or not _is_wider(cube, candidates)]
    costs = [1.0 if cube in own else _CLAUSE + sum(_COST[position] for position in cube) for cube in kept]
    cover = np.array([candidates[cube][moved] for cube in kept], float).T
    found = milp(
        np.array(costs),
        integrality=np.ones(len(kept), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(cover, lb=1),
    )
    taken = np.zeros(len(kept)) if found.x is None else found.x
    return tuple(
        {box.names[i]: bool(position) for i, position in zip(others, cube, strict=True) if position is not None}
        for cube, share in zip(kept, taken, strict=True)
        if share > 0.5
    )


def _position(clause: Clause, name: str) -> int | None:
    return int(clause[name]) if name in clause else None


def _is_wider(cube: _Cube, candidates: Mapping[_Cube, object]) -> bool:
    """Whether a position can be left out of a clause."""
    return any(
        position is not None and (*cube[:i], None, *cube[i + 1 :]) in candidates for i, position in enumerate(cube)
    )
