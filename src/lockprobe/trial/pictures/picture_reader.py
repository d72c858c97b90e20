"""Reads the position of each joint from pictures: a small classical estimator, coarse on purpose.

It knows the spots in the image of each joint's handle at position 0 and at position 1, and decides which spot shows a
handle. It first downsamples the picture to the reader's acuity, as vision models do, so small handles are misread. The
offset of the coarse pixels is a hash of the picture: pseudo-random, but equal for equal pictures in any file. Two cues:

* colour: a handle is more colourful than the board, or of another hue; an empty place is wood, shadow, or a black and
  white mark. The cue is the distance of a chromaticity from all mixtures of the board and grey. Brightness does not
  count;
* depth: a handle stands out of the board, whose plane is fitted to the picture.

The view may have moved a little, of which the recorded camera knows nothing. Where the coarse pixels are small enough,
the spots are first shifted together to where handles are seen.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lockprobe.trial.pictures.frame import from_png, turbo
from lockprobe.trial.pictures.picture import Picture, PictureKind

_REMEMBERED = 256
"""Readings that are kept, so that a picture is not read again at every step."""

Handles = Sequence[tuple[tuple[float, float], tuple[float, float]]]
"""For each joint where its handle is seen, (column, row), at position 0 and at position 1."""

_Image = NDArray[np.float64]
_Places = NDArray[np.float64]
_File = NDArray[np.uint8] | NDArray[np.uint16]

_DISC = 0.12
"""Size of the soft disc that is looked at, as a share of the way from position 0 to position 1."""

_GAZES = ((0.0, 0.0), (0.25, 0.5), (0.5, 0.25), (0.75, 0.75))
"""Offsets of the coarse pixels with which an acuity is tried."""

_FINE = 128
"""Pixels across that a reading of positions resolves. At 64 or more all joints of the twin's pictures are read."""

_CLEAR = 0.3
"""Least evidence for a clear position, 0 to 1; on the twin's pictures without noise all evidence is above 0.65."""

_FEW, _MARGIN = 1 / 16, 1.25
"""Share of joints that the least acuity may misread; a higher one misreads none, and gets so many more pixels."""

_SHARP = 0.3
"""Coarse pixels up to this share of a handle's way show how far the view has moved."""

_STEPS, _FARTHEST, _USUAL_SHIFT = 12, 0.6, 0.35
"""Shifts of the view that are tried in each direction, the farthest, and their usual size, as shares of the way."""

_FAINT = {"rgb": 0.04, "depth": 0.03}
"""The size of either cue at an empty place: a difference of so much is no certainty."""


def shrunk(image: _Image, width: int, gaze: tuple[float, float] = (0.0, 0.0)) -> _Image:
    """A picture (rows, columns, channels) scaled down to ``width`` by averaging over areas, if it is wider.

    ``gaze`` shifts the coarse pixels to the left and up by a fraction of a pixel, [0, 1), so that there is one more in
    either direction, partial at the border.
    """
    if width >= image.shape[1]:
        return image
    size = image.shape[1] / width
    for axis, shift, sums in ((1, gaze[0], "ic,rck->rik"), (0, gaze[1], "jr,rik->jik")):
        pixel = np.arange(image.shape[axis])
        edges = np.clip((np.arange(math.ceil(len(pixel) / size + shift) + 1) - shift) * size, 0, len(pixel))
        # the share of each coarse pixel that each fine pixel covers, shape (coarse, fine)
        covered = np.clip(np.minimum(edges[1:, None], pixel + 1) - np.maximum(edges[:-1, None], pixel), 0, None)
        shares = covered / np.maximum(covered.sum(axis=1, keepdims=True), 1e-12)
        image = np.einsum(sums, shares, image, optimize=True)
    return image


def gaze_at(image: _File) -> tuple[float, float]:
    """The offset of the coarse pixels on a picture, [0, 1) across and down: a hash of its pixels."""
    drawn = hashlib.sha256(f"{image.shape} {image.dtype}".encode() + image.tobytes()).digest()
    return int.from_bytes(drawn[:4], "big") / 2**32, int.from_bytes(drawn[4:8], "big") / 2**32


@lru_cache(_REMEMBERED)
def evidence(pictures: Sequence[Picture], handles: Handles, *, acuity: int) -> tuple[float, ...]:
    """The evidence on each joint's position, from -1 (certainly 0) to 1 (certainly 1), from pictures of one moment.

    It is the mean over the pictures, after downsampling to a width of ``acuity`` pixels.
    """
    return tuple(_mean_cue(pictures, np.array(handles, dtype=float), acuity).tolist())


def _mean_cue(
    pictures: Sequence[Picture], handles: _Places, acuity: int, gaze: tuple[float, float] | None = None
) -> _Image:
    files = [(picture.kind, from_png(picture.png)) for picture in pictures]
    cues = [_cue(kind, file, handles, acuity, gaze_at(file) if gaze is None else gaze) for kind, file in files]
    return np.asarray(np.mean(cues, axis=0))


def clear_positions(rgb: NDArray[np.uint8], handles: Handles | _Places) -> tuple[bool | None, ...]:
    """The position of each joint in a picture, shape (rows, columns, 3); None for a joint without clear evidence."""
    found = _cue("rgb", rgb, np.array(handles, dtype=float), _FINE, gaze_at(rgb))
    return tuple(None if abs(one) < _CLEAR else one > 0 for one in found.tolist())


@lru_cache(_REMEMBERED)
def needed_acuity(pictures: Sequence[Picture], handles: Handles, least: int) -> int:
    """The least acuity that reads pictures as their finest pixels do, wherever the coarse pixels lie.

    ``least`` does if it misreads few joints: how small handles are, and how near to each other, differs between models
    of boxes.
    """
    places = np.array(handles, dtype=float)
    width: int = max(from_png(picture.png).shape[1] for picture in pictures)
    truth = _mean_cue(pictures, places, width, (0.0, 0.0)) > 0
    acuity, most_wrong = least, _FEW
    while acuity < width:
        cues = [_mean_cue(pictures, places, acuity, gaze) for gaze in _GAZES]
        if ((np.array(cues) > 0) != truth).mean() <= most_wrong:
            break
        acuity, most_wrong = math.ceil(1.25 * acuity), 0.0
    return min(acuity if acuity == least else math.ceil(_MARGIN * acuity), max(width, least))


def _cue(kind: PictureKind, file: _File, handles: _Places, acuity: int, gaze: tuple[float, float]) -> _Image:
    """The cue of one picture for each joint, from -1 to 1, shape (joints,)."""
    fine = file / 255.0
    size, gaze = max(fine.shape[1] / acuity, 1.0), gaze if acuity < fine.shape[1] else (0.0, 0.0)
    image = shrunk(fine, acuity, gaze)
    places = (handles + 0.5) / size + gaze - 0.5
    apart = float(np.median(np.linalg.norm(places[:, 1] - places[:, 0], axis=-1)))
    part, first = _around_handles(image, places, apart / 2 + 1)
    if kind == "rgb":
        strange = _strangeness(part)
    else:
        board = _board(*_around_handles(fine, handles, size * apart / 2))
        middles = (np.arange(length) + begin for length, begin in zip(part.shape[1::-1], first, strict=True))
        columns, rows = ((middle + 0.5 - shift) * size - 0.5 for middle, shift in zip(middles, gaze, strict=True))
        near, known = _nearness(part)
        strange = np.where(known, near - (board[0] + board[1] * columns + board[2] * rows[:, None]), 0.0)
    places, disc = places - first, max(_DISC * apart, 0.4)
    if _SHARP * apart >= 1:
        places = places + _view_error(strange, places, apart, disc)
    found = np.clip(_around(strange, places, disc), 0, None)
    certainty: _Image = (found[:, 1] - found[:, 0]) / (found.sum(axis=1) + _FAINT[kind])
    return certainty


def _view_error(strange: _Image, places: _Places, apart: float, disc: float) -> _Places:
    """How far the view has moved, (columns, rows).

    Of all common shifts of the places it is the one under which most stands out at one place of every joint, and a
    small one if in doubt. A shift by the whole way of all joints cannot be told from their moves.
    """
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(np.clip(strange, 0, None), disc, mode="constant")
    steps = np.arange(-_STEPS, _STEPS + 1) * (_FARTHEST * apart / _STEPS)
    shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    columns, rows = np.rint(places + shifts[:, None, None]).astype(np.int64).transpose(3, 0, 1, 2)
    inside = (columns >= 0) & (rows >= 0) & (columns < strange.shape[1]) & (rows < strange.shape[0])
    seen = np.where(inside, smooth[rows.clip(0, strange.shape[0] - 1), columns.clip(0, strange.shape[1] - 1)], 0.0)
    score = seen.max(axis=-1).sum(axis=-1) * np.exp(-((shifts / (_USUAL_SHIFT * apart)) ** 2).sum(axis=-1) / 2)
    best: _Places = shifts[int(score.argmax())]
    return best


def _around_handles(image: _Image, places: _Places, margin: float) -> tuple[_Image, NDArray[np.int64]]:
    """The part of an image in which handles lie, and its first column and row."""
    first = np.clip(places.min(axis=(0, 1)) - margin, 0, np.array(image.shape[1::-1]) - 1).astype(np.int64)
    last = np.ceil(places.max(axis=(0, 1)) + margin + 1).astype(np.int64)
    return image[first[1] : last[1], first[0] : last[0]], first


def _around(values: _Image, places: _Places, size: float) -> _Image:
    """The mean of an image in soft discs around places, shape (joints, 2)."""
    columns, rows = (
        np.exp(-(((np.arange(length) - places[..., axis, None]) / size) ** 2) / 2)
        for axis, length in enumerate(values.shape[::-1])
    )
    total = np.einsum("jpr,rc,jpc->jp", rows, values, columns, optimize=True)
    mean: _Image = total / np.maximum(rows.sum(axis=-1) * columns.sum(axis=-1), 1e-12)
    return mean


def _strangeness(image: _Image) -> _Image:
    """The distance of each pixel's chromaticity from all mixtures of the board's colour and grey."""
    brightness, dim = image.sum(axis=-1, keepdims=True), 0.15  # below which a colour is hardly told from grey
    chromaticity = (image + dim / 3) / (brightness + dim)
    away, across = chromaticity - 1 / 3, np.median(chromaticity.reshape(-1, 3), axis=0) - 1 / 3
    along = np.clip(away @ across / max(float(across @ across), 1e-9), 0, 1)
    distance: _Image = np.linalg.norm(away - along[..., None] * across, axis=-1)
    return distance


def _board(image: _Image, first: NDArray[np.int64]) -> _Image:
    """The plane of the board: nearness at column 0 and row 0, and its slopes per column and row; 0 if unknown."""
    step = max(1, min(image.shape[:2]) // 40)  # single fine pixels do: the board is large
    near, known = _nearness(image[::step, ::step])
    row, column = np.mgrid[: near.shape[0], : near.shape[1]] * step
    terms = np.stack([np.ones_like(near), column + first[0], row + first[1]], axis=-1)[known]
    sample = near[known]
    board = np.zeros(3)
    left = np.ones(sample.shape, dtype=bool)
    for _ in range(4 if sample.size else 0):  # each without the points that stand out of it
        board = np.linalg.lstsq(terms[left], sample[left], rcond=None)[0]
        away = np.abs(sample - terms @ board)
        left = away <= max(float(np.median(away)), 1e-4)
    return board


def _nearness(image: _Image) -> tuple[_Image, NDArray[np.bool_]]:
    """The nearness (or height) at each pixel of a depth picture, and whether the pixel has a reading."""
    from scipy.spatial import KDTree

    nearest = np.asarray(KDTree(np.concatenate([turbo() / 255.0, np.zeros((1, 3))])).query(image)[1])
    return nearest / 255.0, nearest < 256
