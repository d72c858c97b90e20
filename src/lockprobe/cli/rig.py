"""``lockprobe rig``: prepares a robot and its camera for a study."""

from __future__ import annotations

import typer

from lockprobe.cli.rig_calibrate import calibrate
from lockprobe.cli.rig_tags import tags

__all__ = ["app"]

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.command("tags")(tags)
app.command("calibrate")(calibrate)
