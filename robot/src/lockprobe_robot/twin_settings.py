"""Settings of the plants ``twin`` and ``fast-twin``, each an option in a spec: ``twin?pose_error=0.004``.

``twin?model=FILE`` has other settings, because a user's model does not have our panel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lockprobe.foundation.validation import Checked, Within


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings(Checked):
    """The settings that all simulated plants share, because all have a camera.

    Attributes:
        width: Width of pictures, pixels.
        height: Height of pictures, pixels.
        depth_noise: Standard deviation of depth at 0.7 m, metres; it grows with the square of depth.
        labels: Whether the labels of the joints are on the board.
        view_jitter: Standard deviation of the camera's shift along each axis, millimetres; drawn for every picture. The
            robot does not know of it: the recorded camera is the nominal one.

    Raises:
        BadValue: If a setting is out of range.
    """

    width: Annotated[int, Within(64, 4096)] = 640
    height: Annotated[int, Within(64, 4096)] = 480
    depth_noise: Annotated[float, Within(0, 0.1)] = 0.0
    labels: bool = True
    view_jitter: Annotated[float, Within(0, 50)] = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneSettings(CameraSettings):
    """The settings of ``fast-twin``: a physical lockbox and its camera.

    Attributes:
        tilt: Tilt of the panel from lying flat towards the robot, degrees.
        looks: One appearance for every trial, or colours, wood, light and camera drawn in each trial.
        friction: Friction of every joint, as a multiple of the default.
        discs: Whether a white disc marks position 0 of every handle, and a black one position 1.
        board: Wood with the track of every handle, and discs, painted on it, or wood alone.
        handle_colours: Handles of one colour on bars of another, or handles and bars of one colour.
        light: As ``looks`` has it; a low lamp at the right, which casts long shadows; or 30 % of the light.
        colours: As ``looks`` has them; a second palette; or wood, handles, bars and ground drawn in each trial.
        viewpoint: As ``looks`` has it, or from the left side of the board.
        clutter: Number of small objects on the board, at places drawn in each trial.
    """

    tilt: Annotated[float, Within(0, 80)] = 20.0
    looks: Literal["plain", "varied"] = "plain"
    friction: Annotated[float, Within(0, 10)] = 1.0
    discs: bool = True
    board: Literal["painted", "bare"] = "painted"
    handle_colours: Literal["coloured", "plain"] = "coloured"
    light: Literal["plain", "side", "dim"] = "plain"
    colours: Literal["plain", "second", "drawn"] = "plain"
    viewpoint: Literal["plain", "oblique"] = "plain"
    clutter: Annotated[int, Within(0, 20)] = 0


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

    pose_error: Annotated[float, Within(0, 0.05)] = 0.0
    force_noise: Annotated[float, Within(0, 10)] = 0.0
    hand: str = ""
    hand_digest: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class UserModelSettings(CameraSettings):
    """The settings of ``twin?model=FILE``: a user's own model and its camera.

    Attributes:
        model: The MJCF file.
        digest: Digest of the file and all files that it refers to, 16 hexadecimal digits; other files are refused.
            Empty: any.
        force: Push on a sliding joint, newtons.
        torque: Push on a turning joint, newton metres. The default is 30 N at 6 cm, as on levers of ``fast-twin``.
    """

    model: str
    digest: str = ""
    force: Annotated[float, Within(0.01, 1e4)] = 30.0
    torque: Annotated[float, Within(1e-3, 1e3)] = 1.8
