"""What a plant shows: pictures of the moment, for as long as the moment lasts, and what they were made by."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial

import mujoco
import numpy as np

from lockprobe.errors import PlantFault
from lockprobe.lockbox.box import Configuration
from lockprobe.pictures.frame import Frame
from lockprobe.plants.rendering.plant_camera import Eye
from lockprobe.plants.scene.board import Scene
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.settings import SceneSettings
from lockprobe.record import Fact

__all__ = ["Sight"]


class Sight:
    """A plant's camera and moments. Attempts end moments; nobody need look.

    Args:
        model: The compiled scene, with whatever was added to it.
        data: Its state, which is seen and not changed.
        mechanism: Its joints.
        scene: Where the panel is, and which camera looks at it.
        settings: Of the plant.
        rng: For the noise of depth, the camera's own.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        mechanism: Mechanism,
        scene: Scene,
        settings: SceneSettings,
        rng: np.random.Generator,
    ) -> None:
        self._data, self._panel, self._settings, self._rng = data, scene.panel, settings, rng
        self._mechanism = mechanism
        self._eye = Eye(model, scene.camera, settings)
        self._moment = 0
        self._renderer: str | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Of the plant, for the record: engine, settings, and what made the last picture (None if none was taken)."""
        return {"engine": f"mujoco {mujoco.__version__}", **asdict(self._settings), "renderer": self._renderer}

    def now(self) -> Callable[[], Frame]:
        """A way to look at this moment; what it returns raises PlantFault once the moment is over."""
        return partial(self._look, self._moment, None)

    def otherwise(self) -> Callable[[Configuration], Frame]:
        """A way to draw this moment in another configuration, all else as it is; else as :meth:`now`."""
        return partial(self._look, self._moment)

    def _look(self, moment: int, configuration: Configuration | None) -> Frame:
        if self._moment != moment:
            raise PlantFault("a picture was asked for after the next attempt")
        data = self._data if configuration is None else self._mechanism.posed(configuration)
        frame = self._eye.look(data, self._panel.pose, self._panel.handles, self._rng)
        self._renderer = frame.renderer
        return frame

    def end_moment(self) -> None:
        """From here on what is seen is another moment."""
        self._moment += 1

    def close(self) -> None:
        """Let go of the renderer."""
        self._eye.close()
