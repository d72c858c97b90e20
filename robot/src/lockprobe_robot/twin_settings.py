"""Settings of the plants ``twin`` and ``fast-twin``, each an option in a spec: ``twin?pose_error=0.004``.

``twin?model=FILE`` has other settings, because a user's model does not have our panel.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, Protocol

from lockprobe.foundation.errors import BadValue

MechanismKind = Literal["contact", "ideal"]
"""Pins and blocks that touch, or joint ranges that are switched (a reference for tests)."""

Looks = Literal["plain", "varied"]
"""One appearance for every trial, or colours, wood, handles, light and camera drawn in each trial."""

Board = Literal["painted", "bare"]
"""Wood with the track of every handle painted on it, or wood alone."""

HandleColours = Literal["coloured", "plain"]
"""Handles of one colour on bars of another, or handles and bars of one colour."""

Light = Literal["plain", "side", "dim"]
"""As ``looks`` has it; a low lamp at the right, which casts long shadows; or 30 % of the light."""

Colours = Literal["plain", "second", "drawn"]
"""As ``looks`` has them; a second palette; or wood, handles, bars and ground drawn in each trial."""

Viewpoint = Literal["plain", "oblique"]
"""As ``looks`` has it, or from the left side of the board."""

HandleShapes = Literal["plain", "ball", "square", "hollow"]
"""As ``looks`` has them; balls on dark stems; square posts; or knobs with a dark hole in the top."""


class CameraSettings(Protocol):
    """The settings that all simulated plants share, because all have a camera."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def width(self) -> int:
        """Width of pictures, pixels."""
        ...

    @property
    def height(self) -> int:
        """Height of pictures, pixels."""
        ...

    @property
    def depth_noise(self) -> float:
        """Standard deviation of depth at 0.7 m, metres."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneSettings:
    """The settings of ``fast-twin``: a physical lockbox and its camera.

    Attributes:
        mechanism: The interlock: physical pins and blocks, or ideal joint ranges.
        tilt: Tilt of the panel from lying flat towards the robot, degrees.
        looks: What varies from trial to trial.
        friction: Friction of every joint, as a multiple of the default.
        width: Width of pictures, pixels.
        height: Height of pictures, pixels.
        depth_noise: Standard deviation of depth at 0.7 m, metres; it grows with the square of depth.
        discs: Whether a white disc marks position 0 of every handle, and a black one position 1.
        board: Whether the tracks of handles, and discs, are painted on the board.
        labels: Whether the labels of the joints are painted on the board.
        handle_colours: Whether a handle differs from its bar in colour.
        light: The light.
        colours: The colours of wood, handles, bars and ground.
        viewpoint: Where the camera stands.
        handle_shape: The visible shape of handles.
        clutter: Number of small objects on and beside the board, at places drawn in each trial.
        view_jitter: Standard deviation of the camera's shift along each axis, millimetres; drawn for every picture. The
            robot does not know of it: the recorded camera is the nominal one.
        view_turn: Standard deviation of the camera's rotation about each axis, degrees, likewise.

    Raises:
        BadValue: If a setting is out of range.
    """

    mechanism: MechanismKind = "contact"
    tilt: float = 20.0
    looks: Looks = "plain"
    friction: float = 1.0
    width: int = 640
    height: int = 480
    depth_noise: float = 0.0
    discs: bool = True
    board: Board = "painted"
    labels: bool = True
    handle_colours: HandleColours = "coloured"
    light: Light = "plain"
    colours: Colours = "plain"
    viewpoint: Viewpoint = "plain"
    handle_shape: HandleShapes = "plain"
    clutter: int = 0
    view_jitter: float = 0.0
    view_turn: float = 0.0

    def __post_init__(self) -> None:
        _within(self, tilt=(0, 80), friction=(0, 10), width=(64, 4096), height=(64, 4096), depth_noise=(0, 0.1))
        _within(self, clutter=(0, 20), view_jitter=(0, 50), view_turn=(0, 10))


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinSettings(SceneSettings):
    """The settings of ``twin``: a physical lockbox with a robot arm.

    Attributes:
        pose_error: Standard deviation of the error in a handle's estimated position, along each axis of the panel's
            plane, metres; drawn for every attempt.
        force_noise: Standard deviation of each force reading, newtons.
        hand: An MJCF file of one's own hand; empty for ours.
        hand_digest: Digest of that file and all that it refers to, 16 hexadecimal digits; others are refused.
    """

    pose_error: float = 0.0
    force_noise: float = 0.0
    hand: str = ""
    hand_digest: str = ""

    def __post_init__(self) -> None:
        SceneSettings.__post_init__(self)
        _within(self, pose_error=(0, 0.05), force_noise=(0, 10))


@dataclass(frozen=True, slots=True, kw_only=True)
class UserModelSettings:
    """The settings of ``twin?model=FILE``: a user's own model and its camera.

    Attributes:
        model: The MJCF file.
        root: Folder with the model and all files that it refers to. Empty: the folder of the model.
        digest: Digest of the file and all files that it refers to, 16 hexadecimal digits; other files are refused.
            Empty: any.
        force: Push on a sliding joint, newtons.
        torque: Push on a turning joint, newton metres. The default is 30 N at 6 cm, as on levers of
            ``fast-twin``.
        width: As in :class:`SceneSettings`, like the following settings: pixels.
        height: Pixels.
        depth_noise: Metres.

    Raises:
        BadValue: If a setting is out of range.
    """

    model: str
    root: str = ""
    digest: str = ""
    force: float = 30.0
    torque: float = 1.8
    width: int = 640
    height: int = 480
    depth_noise: float = 0.0

    @property
    def folder(self) -> Path | None:
        """The root as a path; None for the folder of the model."""
        return Path(self.root) if self.root else None

    def __post_init__(self) -> None:
        if not self.model:
            raise BadValue("model", self.model, "an MJCF file")
        _within(self, force=(0.01, 1e4), torque=(1e-3, 1e3), width=(64, 4096), height=(64, 4096), depth_noise=(0, 0.1))


def _within(settings: CameraSettings, **ranges: tuple[float, float]) -> None:
    for name, (least, most) in ranges.items():
        if not least <= (value := getattr(settings, name)) <= most:
            raise BadValue(name, value, f"a number from {least} to {most}")
