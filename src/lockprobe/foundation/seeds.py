"""One tree of random streams: study > repetition > trial > {layout, labels, plant, channel-0, channel-1, agent}.

What is drawn once for a whole study has streams of its own: study > {layout, labels}.

Neither the condition nor the agent is on the path. Trial 7 of repetition 2 gets the same labels, the same luck in every
channel and the same draws for its agent whatever the flip probability is and for every agent, so conditions and
agents are compared on common random numbers: the flips at p = 0.2 are a subset of those at p = 0.4.
"""

from __future__ import annotations

import hashlib

import numpy as np


def _entropy(seed: int, path: tuple[str | int, ...]) -> bytes:
    text = "/".join([str(seed), *map(str, path)])
    return hashlib.sha256(text.encode()).digest()[:16]


def generator(seed: int, *path: str | int) -> np.random.Generator:
    """The random stream at one place of the tree, for example ``generator(seed, "rep", 2, "trial", 7, "agent")``.

    It depends on the seed, any integer, and on every part of the path, and on nothing else.
    """
    words = np.frombuffer(_entropy(seed, path), dtype="<u4")  # a number of 128 bits would be taken apart into these
    return np.random.Generator(np.random.PCG64(words))


def integer_seed(seed: int, *path: str | int) -> int:
    """A seed in [0, 2**31) for a place of the tree, for runtimes that take a number."""
    return int.from_bytes(_entropy(seed, path), "little") % 2**31


def study_stream(seed: int, name: str) -> np.random.Generator:
    """A stream of a whole study, by its name; the same for every trial, condition and agent."""
    return generator(seed, "study", name)


def trial_stream(seed: int, repetition: int, trial: int, name: str) -> np.random.Generator:
    """One of a trial's streams, by its name; the same for every condition and agent. Both numbers are from 1."""
    return generator(seed, "rep", repetition, "trial", trial, name)


UNDRAWN = generator(0, "undrawn")
"""The stream of all that draws nothing, since to seed one takes as long as two steps of a trial."""
