"""What a depth camera makes of true depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["sense_depth"]

_REFERENCE = 0.7
"""Metres at which the noise is as large as stated; it grows with the square of depth, as stereo cameras' does."""

_STEP = 0.02
"""Metres between neighbouring pixels from which on the border between them counts as an edge."""

_LOST = 0.6
"""Share of pixels at such edges that have no reading."""


def sense_depth(depth: NDArray[np.float32], noise: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Depth as a camera reads it: in whole millimetres, noisy, with holes along edges.

    Without noise only the rounding is left. One number is drawn from ``rng`` whatever the noise is, and a given
    stream gives the same noise at every size of it.

    Args:
        depth: Shape (height, width), metres; 0 where there is nothing.
        noise: Standard deviation at 0.7 m, metres.
        rng: Random stream.

    Returns:
        The same shape; 0 where there is no reading.
    """
    luck = np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))
    read = depth
    if noise > 0:
        errors = luck.standard_normal(depth.shape, dtype=np.float32)
        lost = luck.random(depth.shape, dtype=np.float32) < _LOST
        read = depth + np.float32(noise) * (depth / np.float32(_REFERENCE)) ** 2 * errors
        read = np.where((depth > 0) & ~(lost & _edges(depth)), read, np.float32(0))
    rounded: NDArray[np.float32] = np.rint(read * np.float32(1000)) / np.float32(1000)
    return rounded


def _edges(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels on both sides of a step in depth."""
    edges = np.zeros(depth.shape, dtype=bool)
    across = np.abs(np.diff(depth, axis=1)) > _STEP
    edges[:, :-1] |= across
    edges[:, 1:] |= across
    down = np.abs(np.diff(depth, axis=0)) > _STEP
    edges[:-1] |= down
    edges[1:] |= down
    return edges
