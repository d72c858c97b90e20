"""What a film of an arm needs of a simulation: the camera of ``scene.xml``, and a call at regular intervals."""

from __future__ import annotations

import mujoco
import numpy as np

from lockprobe.plants.catalogue import FilmHook

FILM_CAMERA = "oblique"

_EVERY = 1 / 25
"""Seconds between two pictures."""

BOARD = np.array([0.42, 0.03, 0.16])
"""What the camera looks at, metres from the base of the arm."""


class Filming:
    """Passes a simulation to a film at regular intervals; called after every step of the simulation.

    Args:
        film: Called with the model and its state, which it must not change; None if there is no film.
        model: The compiled scene.
        data: Its state.
    """

    def __init__(self, film: FilmHook | None, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._film, self._model, self._data = film, model, data
        self._next = 0.0

    def __call__(self) -> None:
        """Pass on the state if a picture is due."""
        if self._film is not None and self._data.time >= self._next:
            self._next += _EVERY
            self._film(self._model, self._data)
