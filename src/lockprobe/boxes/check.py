"""Checks whether a box can be played, and the reason if not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lockprobe.boxes.box import Clause, Lockbox
from lockprobe.boxes.state_space import holds, space_of

__all__ = ["Fault", "FaultKind", "fault_of"]

FaultKind = Literal["nothing moves", "unsolvable", "contradictory", "too short"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """The reason why a box cannot be played.

    Attributes:
        kind: ``nothing moves``: every joint is locked at the start. ``unsolvable``: no sequence of attempts moves the
            target. ``contradictory``: an alternative of the target holds in no reachable configuration. ``too short``:
            the optimum has fewer steps than required.
        reason: The reason in one line, with the names of joints.
    """

    kind: FaultKind
    reason: str


def fault_of(box: Lockbox, shortest: int = 1) -> Fault | None:
    """The reason why a box cannot be played; None if it can be played.

    Args:
        box: The box.
        shortest: Least allowed optimum, steps.
    """
    space = space_of(box)
    if not space.may_move[space.start].any():
        return Fault(kind="nothing moves", reason="unsolvable: nothing moves, every joint is locked at the start")
    if space.optimum is None:
        return Fault(kind="unsolvable", reason=f"unsolvable: no sequence of attempts moves {box.target}")
    for clause in box.interlock.get(box.target, ()):
        if not holds(box, clause, space.reachable).any():
            return Fault(
                kind="contradictory",
                reason=f"contradictory: {_words(clause)} of target {box.target} holds in no configuration that can be "
                "reached",
            )
    if space.optimum < shortest:
        return Fault(kind="too short", reason=f"too short: solved in {space.optimum} of at least {shortest} steps")
    return None


def _words(clause: Clause) -> str:
    return "{" + ", ".join(f"{other} = {int(position)}" for other, position in clause.items()) + "}"
