"""What a film of an arm needs of a simulation: a camera that sees arm and board, and a call at regular intervals."""

from __future__ import annotations

import mujoco
import numpy as np

from lockprobe.plants.catalogue import FilmHook

FILM_CAMERA = "oblique"

_EVERY = 1 / 25
"""Seconds between two pictures."""

BOARD = np.array([0.42, 0.03, 0.16])
"""What the camera looks at, metres from the base of the arm."""

_EYE = np.array([-0.30, 0.60, 0.76])
"""Where it stands: at the arm's left shoulder, so that letters on the board are upright."""


def add_film_camera(spec: mujoco.MjSpec) -> None:
    """Add the camera for films to a scene; it looks at the board over the arm's shoulder."""
    back = (_EYE - BOARD) / np.linalg.norm(_EYE - BOARD)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array([right, np.cross(back, right), back]).T.ravel())
    spec.worldbody.add_camera(name=FILM_CAMERA, pos=_EYE, quat=quaternion, fovy=33.0)


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
