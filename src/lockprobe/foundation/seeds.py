"""Random streams of what is drawn outside trials, by name: boxes, assignments, tests, simulations.

The luck of trials has addresses (:mod:`lockprobe.trial.luck`).
"""

from __future__ import annotations

import hashlib

import numpy as np


def _entropy(seed: int, path: tuple[str | int, ...]) -> bytes:
    text = "/".join([str(seed), *map(str, path)])
    return hashlib.sha256(text.encode()).digest()[:16]


def generator(seed: int, *path: str | int) -> np.random.Generator:
    """The random stream of a seed, any integer, and a path, for example ``generator(seed, "study", "layout")``."""
    words = np.frombuffer(_entropy(seed, path), dtype="<u4")  # a number of 128 bits would be taken apart into these
    return np.random.Generator(np.random.PCG64(words))


def integer_seed(seed: int, *path: str | int) -> int:
    """A seed in [0, 2**31) for a path, for runtimes that take a number."""
    return int.from_bytes(_entropy(seed, path), "little") % 2**31
