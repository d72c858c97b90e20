"""Luck by address: every random number of a trial has a place of its own, at which its generator is put for each draw.

The address is seed, box, repetition, trial, stream, step and place. Neither the condition nor the agent is in it: trial
7 of repetition 2 has the same labels, the same luck in every channel and the same draws of its agent whatever it is
told, so conditions and agents are compared on common random numbers. The flips at p = 0.2 are a subset of those at
p = 0.4, a resumed or forked trial goes on where it was, and no draw moves another one.

The numbers are those of Philox4x64-10 (Salmon, Moraes, Dror and Shaw 2011). Its key is made of seed, box and stream,
its counter of place, step, trial and repetition. :meth:`Luck.at` draws them with NumPy's generator for one trial,
:func:`numbers` with arrays for many; both give the same.
"""

from __future__ import annotations

import hashlib
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.foundation.seeds import generator

_Words = NDArray[np.uint64]


class _Nowhere(np.random.bit_generator.ISeedSequence):
    """Seeds a generator that is put elsewhere before it draws; all else takes longer than three steps of a trial."""

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> NDArray[Any]:
        return np.zeros(n_words, dtype)


class Luck:
    """The luck of one trial. Its streams share one generator, which each call of :meth:`at` moves.

    ``seed`` is that of the study, any integer, ``box`` the name of the box, and ``time`` which continuation of a fork
    it is. All numbers but the seed are from 1.
    """

    def __init__(self, *, seed: int, box: str, repetition: int, trial: int, time: int = 1) -> None:
        self.seed, self.box, self.repetition, self.trial, self.time = seed, box, repetition, trial, time
        origin = np.zeros(4, np.uint64)  # as a number it would take twice the time
        self.generator = np.random.Generator(np.random.Philox(_Nowhere(), counter=origin))  # type: ignore[arg-type]
        self._address: dict[str, Any] = {}
        drawn = {"buffer": (0, 0, 0, 0), "buffer_pos": 4, "has_uint32": 0, "uinteger": 0}  # nothing of a block of four
        self._state = {"bit_generator": "Philox", "state": self._address, **drawn}

    def at(self, stream: str, step: int = 0) -> np.random.Generator:
        """A stream at one step, from 1; what is drawn once a trial is at step 0.

        Whatever was drawn before, it begins at its own address. The next call for any stream moves it.
        """
        address = self._address
        address["key"] = _key(self.seed, self.box, stream if self.time == 1 else f"{stream}/luck-{self.time}")
        address["counter"] = 0, step, self.trial, self.repetition
        self.generator.bit_generator.state = self._state
        return self.generator

    def but(self, **changes: Any) -> Luck:
        """The luck of another trial, or of another continuation, by what differs: ``but(trial=8)``."""
        own: dict[str, Any] = {name: getattr(self, name) for name in ("seed", "box", "repetition", "trial", "time")}
        return Luck(**own | changes)

    def physics(self) -> np.random.Generator:
        """What a plant draws from, as its own time passes: the one generator of a trial that goes on. It can spawn."""
        return generator(self.seed, self.box, "rep", self.repetition, "trial", self.trial, "plant")


@lru_cache(maxsize=4096)
def _key(seed: int, box: str, stream: str) -> tuple[int, int]:
    """The key of a stream: two words of 64 bits."""
    hashed = hashlib.sha256(f"{seed}/{box}/{stream}".encode()).digest()
    return int.from_bytes(hashed[:8], "little"), int.from_bytes(hashed[8:16], "little")


def numbers(
    box: str,
    stream: str,
    *,
    seed: ArrayLike,
    repetition: ArrayLike,
    trial: ArrayLike,
    step: ArrayLike = 0,
    places: int = 1,
) -> NDArray[np.float64]:
    """The first numbers of a stream in many trials, in [0, 1): what ``at(step).random(places)`` gives in each of them.

    Seed, repetition, trial and step may be arrays whose shapes broadcast; step 0 is what is drawn once a trial. The
    result has their shape, of at least one dimension, and ``places`` behind it.
    """
    return drawn(keys(box, stream, seed), repetition=repetition, trial=trial, step=step, places=places)


def keys(box: str, stream: str, seed: ArrayLike) -> _Words:
    """The keys of a stream under seeds of any size in the ten rounds of Philox: two words, shape (10, 2, seeds)."""
    seeds = np.atleast_1d(np.array(seed, object))
    first = np.array([_key(one, box, stream) for one in seeds.ravel().tolist()], np.uint64).T.reshape(2, *seeds.shape)
    return np.stack([first + np.uint64(turn) * _BUMPS.reshape(2, *(1,) * seeds.ndim) for turn in range(10)])


def drawn(
    keys: _Words, *, repetition: ArrayLike, trial: ArrayLike, step: ArrayLike = 0, places: int = 1
) -> NDArray[np.float64]:
    """The numbers of a stream with these :func:`keys`, as :func:`numbers` gives them."""
    counters = (np.atleast_1d(np.asarray(part, np.uint64)) for part in (trial, step, repetition))
    trials, steps, repetitions = np.broadcast_arrays(*counters)
    keys = keys.reshape(10, 2, *(1,) * (trials.ndim - keys.ndim + 2), *keys.shape[2:])
    blocks = [_philox(np.uint64(1 + block), trials, steps, repetitions, keys) for block in range(-(-places // 4))]
    words = np.stack([word for block in blocks for word in block][:places], axis=-1)
    return np.asarray((words >> np.uint64(11)) * 2.0**-53, np.float64)


_FACTORS = np.array((0xD2E7470EE14C6C93, 0xCA5A826395121157), np.uint64)
_BUMPS = np.array((0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B), np.uint64)


def _philox(block: np.uint64, trial: _Words, step: _Words, repetition: _Words, keys: _Words) -> tuple[_Words, ...]:
    """The four outputs of Philox4x64-10 at the counters (block, step, trial, repetition)."""
    half, low = np.uint64(32), np.uint64(2**32 - 1)
    factors = _FACTORS.reshape(2, *(1,) * trial.ndim)
    upper, lower = factors >> half, factors & low
    even, odd = np.stack((np.full_like(trial, block), trial)), np.stack((step, repetition))
    for key in keys:  # in place where that is possible: half of the time of an environment is spent here
        high, rest = even >> half, even & low
        product = lower * rest
        product >>= half
        product += upper * rest
        rest = product & low
        product >>= half
        rest += lower * high
        rest >>= half
        high *= upper
        high += product
        high += rest  # the higher 64 bits of the products
        odd ^= key
        even *= factors
        even, odd = high[::-1] ^ odd, even[::-1]
    return even[0], odd[0], even[1], odd[1]
