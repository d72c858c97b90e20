"""``lockprobe rig tags``: writes a sheet of AprilTags to print."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.storage.atomic_file import write_file

__all__ = ["tags"]


def tags(
    out: Annotated[Path, typer.Option(metavar="FILE", help=options.with_brackets(options.OUT, ".pdf or .svg"))] = Path(
        "tags.pdf"
    ),
) -> None:
    """Write an A4 sheet with the AprilTags of a board, in true scale."""
    form = out.suffix.removeprefix(".")
    if form not in ("pdf", "svg"):
        raise BadValue("--out", str(out), "a file name that ends in .pdf or .svg")
    from lockprobe_robot.calibration.opencv import tag_bits
    from lockprobe_robot.scene.tag_layout import NUMBERS, TAG_SIDE

    bits = tag_bits(NUMBERS)  # without OpenCV it ends here, before slower imports
    from lockprobe_robot.tag_sheet import tag_sheet
    from lockprobe_robot.true_scale import true_scale_file

    figure = tag_sheet(bits, NUMBERS, 1000 * TAG_SIDE)
    write_file(out, true_scale_file(figure, "pdf" if form == "pdf" else "svg"))
    print(out)
