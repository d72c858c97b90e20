"""What an agent saw: of each modality with pictures, those of one trial before its first step and after some steps."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockprobe.errors import BadFile, BadValue, Missing
from lockprobe.pictures.picture import PICTURE_NAME, PictureKind
from lockprobe.pictures.png import from_png, to_png
from lockprobe.record import Trial
from lockprobe.studies.picture_store import read_picture

__all__ = ["SeenModality", "SeenMoment", "embedded", "seen"]

_SHOWN: tuple[PictureKind, ...] = ("rgb", "depth")
"""Kinds that agents are shown; the others are kept for the record."""

_WIDE = 320
"""Pixels across a picture on a page, at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenMoment:
    """Pictures of one moment of a trial: kind of picture -> file name."""

    when: str
    text: str
    files: Mapping[PictureKind, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenModality:
    """What an agent saw in one trial."""

    modality: str
    key: str
    moments: Sequence[SeenMoment]


def seen(trials: Sequence[Trial]) -> list[SeenModality]:
    """The pictures of a trial of each modality, the first that was played for a step, and what is known of them.

    Three moments: before the first step, after it, and after the first that moved something.
    """
    found: dict[str, SeenModality] = {}
    for trial in trials:
        if trial.modality not in found and trial.opening_pictures and trial.steps:
            files = _files(trial.opening_pictures)
            opening = SeenMoment(when="before the first step", text=trial.opening, files=files)
            first_move = next((step for step in trial.steps if step.moved), trial.steps[0])
            moments = [opening, *(_moment(trial, number) for number in dict.fromkeys((1, first_move.step)))]
            found[trial.modality] = SeenModality(
                modality=trial.modality,
                key=trial.key,
                moments=[moment for moment in moments if moment.files],
            )
    return list(found.values())


def _moment(trial: Trial, number: int) -> SeenMoment:
    step = trial.steps[number - 1]
    what = "moved" if step.moved else "did not move"
    when = f"after step {number}: {step.joint} {what}"
    return SeenMoment(when=when, text=step.told, files=_files(step.pictures))


def _files(pictures: Mapping[PictureKind, str]) -> dict[PictureKind, str]:
    return {kind: pictures[kind] for kind in _SHOWN if kind in pictures}


def embedded(directory: Path, rows: Sequence[SeenModality]) -> dict[str, str]:
    """The pictures that rows name as data for a page, made small.

    Those that are not there or damaged are left out, and all where the package that reads pictures is missing.
    """
    files = {item for row in rows for moment in row.moments for item in moment.files.items()}
    small = {name: _small(directory, name, kind) for kind, name in sorted(files) if PICTURE_NAME.fullmatch(name)}
    return {
        name: "data:image/png;base64," + base64.b64encode(png).decode()
        for name, png in small.items()
        if png is not None
    }


def _small(directory: Path, name: str, kind: PictureKind) -> bytes | None:
    """Of colours, the mean of every block; of depth, one pixel of it: the mean of two codes is the code of neither."""
    try:
        png = read_picture(directory, name)
        pixels = from_png(png)
    except (BadFile, BadValue, Missing):
        return None
    step = -(-pixels.shape[1] // _WIDE)
    if kind == "depth":
        return to_png(pixels[step // 2 :: step, step // 2 :: step])
    high, wide = (side // step * step for side in pixels.shape[:2])
    blocks = pixels[:high, :wide].reshape(high // step, step, wide // step, step, -1).mean(axis=(1, 3))
    return to_png(blocks.round().astype(pixels.dtype).squeeze())
