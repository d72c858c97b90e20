"""The plant of an episode, with at most one look per moment."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
from dataclasses import replace

from lockprobe.boxes.box import Configuration
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.plants.catalogue import plant_of
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.protocols import Plant
from lockprobe.trial.record import Fact, Snapshot


def make_plant(plan: Plan, names: Names) -> Plant:
    """A fresh plant for a trial, with the trial's stream, as in studies."""
    return plant_of(plan, names.labels)


_ABANDONED: list[Plant] = []
"""Plants of a process from which this one was forked. Closing their OpenGL here would hang."""


class WatchedPlant:
    """A plant that remembers its configuration, and its picture, which is taken at most once.

    Args:
        make: Makes the plant at the first observation, where an error is the plant's fault.

    Attributes:
        configuration: The present configuration in panel order.
    """

    def __init__(self, make: Callable[[], Plant]) -> None:
        self.configuration: Configuration = ()
        self._make = make
        self._plant: Plant | None = None
        self._process = 0
        self._now: Snapshot | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Facts of the plant; none before it is made."""
        return {} if self._plant is None else self._plant.facts

    def observe(self) -> Snapshot:
        """The truth before the first attempt."""
        self._plant, self._process = self._make(), os.getpid()
        return self._noted(self._plant.observe())

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by index in panel order."""
        assert self._plant is not None
        if self._process != os.getpid():
            raise PlantFault("the plant belongs to the parent process: call reset()")
        return self._noted(self._plant.attempt(joint))

    def frame(self) -> Frame:
        """The camera's picture now.

        Raises:
            BadValue: If the plant has no camera.
        """
        if self._now is None or self._now.look is None:
            raise BadValue("plant", type(self._plant).__name__, "a plant with a camera")
        return self._now.look()

    def close(self) -> None:
        """Close the plant. Idempotent."""
        plant, self._plant, self._now = self._plant, None, None
        if plant is None:
            return
        if self._process == os.getpid():
            plant.close()
        else:
            _ABANDONED.append(plant)

    def _noted(self, snapshot: Snapshot) -> Snapshot:
        if snapshot.look is not None or snapshot.render is not None:
            look, render = (None if way is None else functools.cache(way) for way in (snapshot.look, snapshot.render))
            snapshot = replace(snapshot, look=look, render=render)
        self._now, self.configuration = snapshot, snapshot.configuration
        return snapshot
