"""The modalities ``rgb`` and ``rgbd``: the box as pictures, with or without depth (paper, Sec. 2.2).

A picture shows the report: the truth, or what interventions made of it. It can also be degraded, as if by a lens, a
sensor or an obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import Checked, Share, Within
from lockprobe.interventions.words import places_said, rows_of
from lockprobe.trial.pictures.frame import degraded, to_millimetres, to_png, turbo
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Moment, Percept, Task

NEAR, FAR = 0.64, 0.78
"""What the first and the last colour of depth mean, metres, in every picture the same.

The window holds the tops of all handles and most of the board where a camera looks at a panel from 0.72 m; the 0.05 m
by which handles stand out are a third of it.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraChannel(Checked):
    """Takes a picture of the box and removes outcome and positions from the report: only the picture shows them.

    What is pictured are the positions of the percept; where they are not the true ones, the plant draws what is told.
    Where the percept holds no positions, there is no picture and no text. Where pictures show no labels of joints, the
    text of the first one says where they lie.

    With depth, the picture of depth is made of whole millimetres, and these are kept with it for the record, so that
    it can be made again in another form.

    Attributes:
        depth: Whether a picture of depth follows that of colours.
        blur: Standard deviation of a Gaussian blur of colours, pixels, [0, 1000]. Depth stays as it is.
        noise: Standard deviation of noise in every pixel and colour, as a share of the brightest, [0, 1000]. Depth
            stays as it is: its noise is a setting of the plant (``depth_noise``).
        occlude: Share of the panel that an opaque patch hides, [0, 1], at a place drawn for every picture. What it
            hides has no depth.
        exposure: Stops of exposure of colours, [-20, 20]; negative is darker. Depth stays as it is.
    """

    always_tells: ClassVar[bool] = True
    depth: bool = False
    blur: Annotated[float, Within(0, 1000)] = 0.0
    noise: Annotated[float, Within(0, 1000)] = 0.0
    occlude: Share = 0.0
    exposure: Annotated[float, Within(-20, 20)] = 0.0

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept as pictures."""
        luck = rng.random(3)
        if percept.look is None:
            modality = "rgbd" if self.depth else "rgb"
            raise BadValue("modality", modality, "symbolic, or a plant with a camera: fast-twin or twin")
        if percept.positions is None:
            return replace(percept, outcome=None, text="")
        damage = {name: getattr(self, name) for name in ("blur", "noise", "occlude", "exposure")}
        frame = degraded(percept.look(percept.positions), luck, **damage)
        pictures: tuple[Picture, ...] = (Picture(kind="rgb", png=to_png(frame.rgb)),)
        if self.depth:
            millimetres = to_millimetres(frame.depth)
            shown = encode(millimetres.astype(np.float32) / np.float32(1000))
            measured = Picture(kind="depth16", png=to_png(millimetres), shown=False)
            pictures = (*pictures, Picture(kind="depth", png=to_png(shown)), measured)
        where = places_said(task, rows_of(task)) if percept.joint is None and not frame.labelled else []
        places = frame.camera.project(frame.handles)[..., :2].tolist()
        return replace(
            percept,
            outcome=None,
            positions=None,
            text=" ".join((self.caption(percept.joint), *where)),
            unlabelled=not frame.labelled,
            pictures=pictures,
            handles=tuple(((zero[0], zero[1]), (one[0], one[1])) for zero, one in places),
        )

    def shown(self, percept: Percept) -> object:
        """What the pictures and their text show of a percept: positions and the attempted joint, as a look gives them.

        Without positions there is neither picture nor text.
        """
        return None if percept.positions is None else (percept.positions, percept.joint, percept.look)

    def caption(self, joint: str | None) -> str:
        """The words with the pictures; ``joint`` is the one just attempted, by its label."""
        now = "" if joint is None else " now"
        attempted = "" if joint is None else f"You attempted {joint}. "
        if not self.depth:
            return f"{attempted}The picture shows the box{now}."
        shows = f"{attempted}The first picture shows the box{now}, the second its depth."
        if joint is not None:
            return shows
        return (
            f"{shows} Colour is distance from the camera: red {NEAR:g} m or nearer, through yellow, green and "
            f"blue to dark violet {FAR:g} m or farther, black no reading."
        )


def encode(depth: NDArray[np.float32], near: float = NEAR, far: float = FAR) -> NDArray[np.uint8]:
    """Encode depth as a picture, shape (height, width, 3). A value outside the window has the colour of its nearer end.

    ``depth`` has the shape (height, width), metres; 0 where there is no reading, which is black.
    """
    level: NDArray[np.uint8] = np.rint(np.clip((depth - far) / (near - far), 0, 1) * 255).astype(np.uint8)
    colours = np.take(turbo(), level, axis=0)
    colours[depth <= 0] = 0
    return colours
