"""Checks whether a box can be played, and the reason if not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.state_space import Space, holds, space_of

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
        said = f"unsolvable: nothing moves, every joint is locked at the start{_cycle_said(box, space)}"
        return Fault(kind="nothing moves", reason=said)
    if space.optimum is None:
        said = f"unsolvable: no sequence of attempts moves {box.target}{_cycle_said(box, space)}"
        return Fault(kind="unsolvable", reason=said)
    for clause in box.interlock.get(box.target, ()):
        if not holds(box, clause, space.reachable).any():
            words = ", ".join(f"{other} = {int(position)}" for other, position in clause.items())
            return Fault(
                kind="contradictory",
                reason=f"contradictory: {{{words}}} of target {box.target} holds in no configuration that can be "
                "reached",
            )
    if space.optimum < shortest:
        return Fault(kind="too short", reason=f"too short: solved in {space.optimum} of at least {shortest} steps")
    return None


def _cycle_said(box: Lockbox, space: Space) -> str:
    """The joints that wait for each other and so keep the target locked, for the end of a reason; empty without any."""
    moves = [column.any() for column in space.may_move[space.reachable].T]
    held = {name: at for name, at, ever in zip(box.names, box.initial, moves, strict=True) if not ever}
    waits = {
        name: [other for clause in box.interlock[name] for other, at in clause.items() if held.get(other, at) != at]
        for name in held
    }
    if not (found := _cycle(waits, [box.target])):
        return ""
    first, *rest = [f"{one} {{}}for {other}" for one, other in zip(found, [*found[1:], found[0]], strict=True)]
    said = [first.format("waits "), *(one.format("") for one in rest)]
    return f": {', '.join(said[:-1])}, and {said[-1]}"


def _cycle(waits: Mapping[str, Sequence[str]], path: list[str]) -> list[str]:
    """The first cycle to which a path leads, depth first; empty if there is none."""
    for other in waits[path[-1]]:
        found = path[path.index(other) :] if other in path else _cycle(waits, [*path, other])
        if found:
            return found
    return []
