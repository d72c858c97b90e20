"""Makes a film of the pictures that an agent saw, from a study's files and without simulation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import read_input
from lockprobe.trial.pictures.picture import PICTURE_NAME, PictureKind
from lockprobe.trial.pictures.png import from_png
from lockprobe.trial.record import Trial
from lockprobe_robot.film.caption import captioned, opening_lines, outcome_lines
from lockprobe_robot.film.files import open_film
from lockprobe_robot.film.replay import Film

_SECONDS = 1.2


def film_seen(trial: Trial, directory: Path, path: Path) -> Film:
    """Film the pictures that the agent of a recorded trial saw, in order.

    Args:
        trial: The record.
        directory: The study's directory of pictures.
        path: The film: ``.gif``, ``.mp4``, or a directory for the pictures.

    Raises:
        UserMistake: If the trial has no pictures, or a file is missing.
    """
    if not trial.opening_pictures:
        raise BadValue(
            "trial", trial.key, "one in which pictures were seen (rgb, rgbd); without --seen it is played again"
        )
    file = open_film(path)
    try:
        file.add(captioned(_shown(directory, trial.opening_pictures), opening_lines(trial)), _SECONDS)
        for at, step in enumerate(trial.steps):
            file.add(captioned(_shown(directory, step.pictures), outcome_lines(trial, at)), _SECONDS)
    finally:
        file.close()
    return Film(path=path, pictures=1 + len(trial.steps), plant="", differs=None)


def _shown(directory: Path, names: Mapping[PictureKind, str]) -> NDArray[np.uint8]:
    """The colour picture, with the depth picture at its right if the agent saw it."""
    kinds: tuple[PictureKind, ...] = ("rgb", "depth")
    return np.concatenate([_read(directory, names[kind]) for kind in kinds if kind in names], axis=1)


def _read(directory: Path, name: str) -> NDArray[np.uint8]:
    path = directory / name
    if not PICTURE_NAME.fullmatch(name):
        raise BadFile(directory, f"the record names a picture {name!r}, which is no name of a picture")
    try:
        picture = from_png(read_input(path)).astype(np.uint8, copy=False)
    except BadValue as mistake:
        raise BadFile(path, str(mistake)) from None
    return np.stack([picture] * 3, axis=-1) if picture.ndim == 2 else picture
