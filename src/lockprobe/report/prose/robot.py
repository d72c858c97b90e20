"""Sentences on a robot: how often arm and camera were wrong, and how often it broke the rules of the box."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.formatting import listed, percent, range_of
from lockprobe.statistics.robot import Judged, RobotSenses
from lockprobe.statistics.rules import RuleBreaks
from lockprobe.trial.source import SourceKind

__all__ = ["broken_said", "not_judged", "rules_said", "senses_said"]

_TOLD: Mapping[SourceKind, str] = {"truth": "the truth", "verdict": "the verdict", "camera": "what the camera saw"}
"""What reports are made of, in words."""


def senses_said(found: RobotSenses) -> str:
    """How often an arm and a camera were wrong about the outcome of attempts, and what agents were told."""
    sentences = []
    if verdict := found.all.verdict:
        sentences.append(_judged(verdict, "The robot's own verdict, from force and distance,", "it could not decide"))
    if camera := found.all.camera:
        sentences.append(_judged(camera, "The outcome that the camera saw", "it could not see the joint clearly"))
    return " ".join([*sentences, _told(found)])


def _judged(found: Judged, what: str, undecided: str) -> str:
    wrong = found.wrong
    if not wrong.n:
        return f"{what} is not known for any of {found.attempts} attempts: {undecided}."
    moved, blocked = found.moved_for_blocked, found.blocked_for_moved
    kinds = f": {moved} took a blocked joint for moved, {blocked} a moved joint for blocked" if wrong.count else ""
    more = f"; {undecided} at {found.undecided} more" if found.undecided else ""
    return (
        f"{what} was wrong at {wrong.count} of {wrong.n} attempts "
        f"({percent(wrong.value, 1)}, 95 % interval {range_of(wrong.low, wrong.high, 1)}){kinds}{more}."
    )


def _told(found: RobotSenses) -> str:
    """What agents were told: the truth, the verdict, or what the camera saw."""
    if set(found.told) == {"truth"}:
        if found.all.verdict and found.all.camera:
            return "Agents are told the truth, and neither of the two."
        return "Agents are not told this verdict." if found.all.verdict else "Agents are told the truth."
    parts = [f"{said} under {listed(found.told[kind])}" for kind, said in _TOLD.items() if kind in found.told]
    return f"Agents are told {listed(parts)}."


def rules_said(found: RuleBreaks) -> str:
    """How many attempts broke the rules of the box, and how; empty if none did."""
    if not found.against:
        return ""
    kinds = [
        f"{count} {what}"
        for count, what in (
            (found.missed, f"of {found.free} at free joints moved nothing"),
            (found.forced, f"of {found.attempts - found.free} at locked joints moved them"),
            (found.others, "moved another joint"),
        )
        if count
    ]
    share = percent(found.against / found.attempts, 1)
    return (
        f"{found.against} of {found.attempts} attempts ({share}) broke the rules of the box: {', '.join(kinds)}. "
        "The plant did that, not the agent. Success, steps and loops count these attempts as they were; success by "
        "chance and the shortest plan are those of a box without them."
    )


def broken_said(found: RuleBreaks | None) -> str:
    """How many attempts broke the rules of the box, in few words; empty if none did."""
    if found is None or not found.against:
        return ""
    return f"{found.against} of {found.attempts} attempts broke the rules of the box."


def not_judged(found: RuleBreaks | None) -> str:
    """Why no claim of the paper is judged: attempts broke the rules of the box; empty if none did."""
    broken = broken_said(found)
    return f"No claim of the paper is judged: {broken}" if broken else ""
