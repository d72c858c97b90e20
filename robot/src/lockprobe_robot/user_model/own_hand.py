"""A user's own hand on the arm (``twin?hand=FILE``): an MJCF file, read as untrusted data within limits."""

from __future__ import annotations

from pathlib import Path

import mujoco

from lockprobe.foundation.errors import BadFile
from lockprobe_robot.arm.hand import add_wrench
from lockprobe_robot.geom_groups import ARM, PANEL
from lockprobe_robot.user_model.compiled_model import BROKEN, compiled_within_limits, without_stderr
from lockprobe_robot.user_model.mjcf_file import read_model

TOOL_SITE = "tool"


def add_own_hand(spec: mujoco.MjSpec, flange: mujoco.MjsBody, path: Path, digest: str) -> None:
    """Mount a hand on the flange, over a force-torque sensor of ours.

    All bodies of the file hang on the flange, with their joints, motors and sensors; ``hand-`` is put before the names.
    The site ``tool`` is where the middle of a knob's top is while the hand holds it, z away from the arm. What can
    touch anything touches the board, its joints and nothing else; motors stay without a command.

    Args:
        spec: The scene; it is changed.
        flange: The body that carries the hand.
        path: The MJCF file.
        digest: What the files' digest has to be; empty for any.

    Raises:
        BadFile: If the file cannot be read, is beyond the limits, is not the one asked for, or has no site ``tool``.
    """
    file = read_model(path)
    if digest not in ("", file.digest):
        raise BadFile(path, f"another hand: its digest is {file.digest}, {digest} was asked for")
    try:
        with without_stderr():
            hand = mujoco.MjSpec.from_string(file.text, assets=dict(file.assets))
            compiled_within_limits(hand, file)
    except BROKEN as error:
        raise BadFile(path, file.explain(str(error))) from None
    sites = [site for site in hand.sites if site.name == TOOL_SITE]
    if not sites or not hand.worldbody.bodies:
        raise BadFile(path, f"no site {TOOL_SITE!r} in a body, which is where the hand holds the top of a knob")
    for key in hand.keys:
        hand.delete(key)
    for geom in hand.geoms:
        if geom.contype or geom.conaffinity:
            geom.contype, geom.conaffinity = ARM, PANEL
    base = flange.add_body(name="hand")
    add_wrench(spec, base)
    spec.assets = {**spec.assets, **file.assets}
    spec.attach(hand, prefix="hand-", frame=base.add_frame())
    spec.site(f"hand-{TOOL_SITE}").name = TOOL_SITE
