"""The box as pictures: in colour, or in colour and depth (paper, Sec. 2.2: RGB and RGB-D)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from lockprobe.errors import BadValue
from lockprobe.pictures.depth import DepthKind, Window, encode, from_millimetres, legend, to_millimetres
from lockprobe.pictures.frame import Frame
from lockprobe.pictures.picture import Picture
from lockprobe.pictures.png import to_png
from lockprobe.record import Moment, Percept, Task

__all__ = ["CameraChannel", "Depth"]

Depth = Literal["none", DepthKind]
"""Whether depth is shown, and how; :mod:`lockprobe.pictures.depth` says what the kinds are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraChannel:
    """Takes a picture of the box and hides all else: neither outcome nor positions are told, pictures show them.

    With depth, the picture of depth is made of whole millimetres, and these are kept beside it for the record, so that
    it can be made again in another form.

    Attributes:
        depth: How depth is shown beside colours.
        near: What the first colour of depth means, metres; in every picture the same.
        far: What the last one means, metres. The default window holds the tops of all handles and most of the board
            where a camera looks at a panel from 0.72 m; the 0.05 m by which handles stand out are a third of it.

    Raises:
        BadValue: If ``depth`` is none of these, or the window is empty.
    """

    depth: Depth = "none"
    near: float = 0.64
    far: float = 0.78

    def __post_init__(self) -> None:
        if self.depth not in get_args(Depth):
            raise BadValue("depth", self.depth, f"one of {', '.join(get_args(Depth))}")
        Window(near=self.near, far=self.far)

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept as pictures. Nothing is drawn from ``rng``.

        Raises:
            BadValue: If the plant has no camera.
        """
        if percept.look is None:
            modality = "rgb" if self.depth == "none" else "rgbd"
            raise BadValue("modality", modality, "a plant with a camera: fast-twin or twin")
        frame = percept.look()
        places = frame.camera.project(frame.handles)[..., :2].tolist()
        return replace(
            percept,
            outcome=None,
            positions=None,
            text=self._text(percept.joint),
            pictures=self._pictures(frame),
            handles=tuple(((zero[0], zero[1]), (one[0], one[1])) for zero, one in places),
        )

    def _pictures(self, frame: Frame) -> tuple[Picture, ...]:
        colours = Picture(kind="rgb", png=to_png(frame.rgb))
        if self.depth == "none":
            return (colours,)
        millimetres = to_millimetres(frame.depth)
        window = Window(near=self.near, far=self.far)
        shown = encode(from_millimetres(millimetres), self.depth, window, frame.camera)
        return (
            colours,
            Picture(kind="depth", png=to_png(shown)),
            Picture(kind="depth16", png=to_png(millimetres), shown=False),
        )

    def _text(self, joint: str | None) -> str:
        now = "" if joint is None else " now"
        attempted = "" if joint is None else f"You attempted {joint}. "
        if self.depth == "none":
            return f"{attempted}The picture shows the box{now}."
        shows = f"{attempted}The first picture shows the box{now}, the second its depth."
        window = Window(near=self.near, far=self.far)
        return shows if joint is not None else f"{shows} {legend(self.depth, window)}"
