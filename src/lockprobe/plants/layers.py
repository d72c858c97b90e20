"""Who can touch whom (bits for MuJoCo's ``contype`` and ``conaffinity``), and what no camera shows."""

from __future__ import annotations

__all__ = ["ARM", "HIDDEN", "NOTHING", "PANEL"]

NOTHING = 0
"""As ``conaffinity`` of the panel's parts, which wait to be touched and never touch each other; as both of what is only
there to be looked at."""

PANEL = 1
"""Board, knobs, bars, levers and ground."""

ARM = 2
"""Links and fingers: they touch the panel, never each other."""

HIDDEN = 4
"""Group of shapes and sites that cameras do not show."""
