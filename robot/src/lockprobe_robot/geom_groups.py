"""The plant's camera, and groups of geoms: which can collide (``contype``, ``conaffinity``), and which it shows."""

from __future__ import annotations

CAMERA = "lockprobe"
"""Name of the plant's camera, in our scene and in a user's model."""

NOTHING = 0
"""``conaffinity`` of the panel's parts, which never touch each other; both bits of geoms that are only looked at."""

PANEL = 1
"""Board, knobs, bars, levers and ground."""

ARM = 2
"""Links and hand: they touch the panel, never each other."""

HIDDEN = 4
"""Group of geoms and sites that cameras do not show."""

SHOWN_GROUPS = (True, True, True, False, False, False)
"""Whether cameras show the geoms of each group."""
