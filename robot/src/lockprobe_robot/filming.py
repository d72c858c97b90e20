"""What a film of an arm needs of a simulation: a camera that sees arm and board, and a call at regular intervals."""

from __future__ import annotations

import mujoco
import numpy as np

from lockprobe.plants.catalogue import FilmHook

FILM_CAMERA = "oblique"

_EVERY = 1 / 25
"""Seconds between two pictures."""

_EYE, _TARGET = np.array([1.25, 0.80, 1.15]), np.array([0.22, 0.0, 0.28])
"""Where the camera stands and what it looks at, metres from the base of the arm."""


def add_film_camera(spec: mujoco.MjSpec) -> None:
    """Add the camera for films to a scene; it looks at board and arm from one side."""
    back = (_EYE - _TARGET) / np.linalg.norm(_EYE - _TARGET)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array([right, np.cross(back, right), back]).T.ravel())
    spec.worldbody.add_camera(name=FILM_CAMERA, pos=_EYE, quat=quaternion, fovy=42.0)


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
