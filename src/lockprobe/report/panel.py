"""The box of a study as a row of joints, for the first screen: letters, the target, and which joint frees which."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

_WIDE, _MOST = 88, 6
"""Pixels of a joint, and joints that are drawn; the drawing of a larger box stands in its part of the page."""


def panel_figure(box: Mapping[str, Any]) -> tuple[Any, str]:
    """The drawing, and what stands below it; both empty where there is none.

    Arrows lead from a joint to the one that it frees, where each joint waits for at most one that stands beside it;
    any other interlock is drawn in its own part of the page.
    """
    joints = [str(joint["name"]) for joint in box.get("joints", [])]
    if not 0 < len(joints) <= _MOST:
        return "", ""
    parts = []
    for i, joint in enumerate(box["joints"]):
        x, goal = 36 + _WIDE * i, " goal" if joint["name"] == box.get("target") else ""
        if joint.get("kind") == "revolute":
            parts.append(f'<circle class="ink{goal}" cx="{x}" cy="32" r="24"/><path class="ink{goal}" d="M{x} 32V12"/>')
        else:
            parts.append(
                f'<rect class="ink{goal}" x="{x - 28}" y="20" width="56" height="24" rx="12"/>'
                f'<circle class="full" cx="{x - 16}" cy="32" r="8"/>'
            )
        parts.append(f'<text class="n2" x="{x}" y="80" text-anchor="middle">{chr(ord("A") + i)}</text>')
        if goal:
            parts.append(f'<text class="q" x="{x}" y="102" text-anchor="middle">target</text>')
    chain = _chain(box, joints)
    for waits, frees in chain or ():
        at, to = (36 + _WIDE * joints.index(name) for name in (frees, waits))
        side = 1 if to > at else -1
        parts.append(
            f'<path class="arrow" d="M{at + 16 * side} 75H{to - 16 * side}m{-6 * side}-4l{6 * side} 4l{-6 * side} 4"/>'
        )
    width = _WIDE * len(joints) - 16
    drawn = (
        f'<svg viewBox="0 0 {width} 108" width="{width}" height="108" role="img" aria-label="The box, joint by joint">'
    )
    said = "An arrow leads from a joint to the one that it frees." if chain else "Which joint locks which is hidden."
    return Markup(drawn + "".join(parts) + "</svg>"), said  # noqa: S704  our own; names stand nowhere in it


def _chain(box: Mapping[str, Any], joints: list[str]) -> list[tuple[str, str]] | None:
    """Each joint with the neighbour that frees it; None for another interlock."""
    found = []
    for joint, clauses in box.get("interlock", {}).items():
        if len(clauses) != 1 or len(clauses[0]) != 1:
            return None
        (other,) = clauses[0]
        if abs(joints.index(joint) - joints.index(other)) != 1:
            return None
        found.append((joint, other))
    return found
