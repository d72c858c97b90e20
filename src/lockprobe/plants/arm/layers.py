"""Who can touch whom (bits for MuJoCo's ``contype`` and ``conaffinity``), and what no camera shows."""

from __future__ import annotations

__all__ = ["ARM", "HIDDEN", "PANEL"]

PANEL = 1
"""Board, knobs, bars and levers."""

ARM = 2
"""Links and fingers: they touch the panel, never each other."""

HIDDEN = 4
"""Group of shapes and sites that cameras do not show."""
