"""Random streams of many trials at once: what :func:`lockprobe.foundation.seeds.trial_stream` gives, more quickly.

A generator of numpy takes longer to make than a trial's numbers to draw. Here its two published algorithms run on
arrays with one entry for each stream: numpy's ``SeedSequence`` (after O'Neill 2015) makes states from seeds, and PCG64
(XSL RR 128/64, O'Neill 2014) makes numbers from states. A number of 128 bits is two of 64, high and low.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import trial_stream

FEW = 6
"""Up to so many streams, numpy's own generators are quicker."""

_Words = NDArray[np.uint32]
_Longs = NDArray[np.uint64]
_Wide = tuple[_Longs, _Longs]
"""Numbers of 128 bits: the higher 64, and the lower 64."""

_POOL = 4
_SHIFT = np.uint32(16)
_LEFT, _RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
_ONE, _HALF, _LOW_HALF = np.uint64(1), np.uint64(32), np.uint64(0xFFFFFFFF)
_FACTOR = 0x2360ED051FC65DA44385DF649FCCF645


def first_numbers(trials: Sequence[tuple[int, int, int]], name: str, count: int) -> NDArray[np.float64]:
    """The first numbers of each trial's stream of a name, in [0, 1), shape (trials, count).

    Args:
        trials: Study seed, repetition and trial of each.
        name: The name of the stream.
        count: How many numbers of each.
    """
    if len(trials) <= FEW:
        return np.array([trial_stream(*trial, name).random(count) for trial in trials]).reshape(-1, count)
    high, low = _states(_begun(trials, name), 1, count)
    mixed, turn = high ^ low, high >> np.uint64(58)
    turned = np.bitwise_or(mixed >> turn, mixed << (-turn & np.uint64(63)))
    return ((turned >> np.uint64(11)) * np.float64(2.0**-53)).T


def generators(trials: Sequence[tuple[int, int, int]], name: str) -> Iterator[np.random.Generator]:
    """A generator at the beginning of each trial's stream of a name; none may be used after the next is asked for."""
    if len(trials) <= FEW:
        yield from (trial_stream(*trial, name) for trial in trials)
        return
    begun, rng = _begun(trials, name), np.random.Generator(np.random.PCG64(0))
    numbers = [part.ravel().tolist() for part in (*_states(begun, 0, 1), *begun[1])]
    for high, low, added_high, added_low in zip(*numbers, strict=True):
        state = {"state": high << 64 | low, "inc": added_high << 64 | added_low}
        rng.bit_generator.state = {"bit_generator": "PCG64", "state": state, "has_uint32": 0, "uinteger": 0}
        yield rng


def _constants(first: int, factor: int, numbers: Sequence[int]) -> tuple[_Words, _Words]:
    """The constants of the hashes with these numbers, from 0: two words each, shape (hashes, 1)."""
    words = [[first * factor**number % 2**32, first * factor ** (number + 1) % 2**32] for number in numbers]
    return np.array(words, dtype=np.uint32)[:, :1], np.array(words, dtype=np.uint32)[:, 1:]


_FILL = _constants(0x43B0D7E5, 0x931E8875, range(_POOL))
_STIR = [  # hashes of one word for each of the other three; the word's own place, 0 here, is not used
    _constants(0x43B0D7E5, 0x931E8875, [0 if i == of else 4 + 3 * of + i - (i > of) for i in range(_POOL)])
    for of in range(_POOL)
]
_DRAW = _constants(0x8B51F9DD, 0x58F38DED, range(2 * _POOL))


def _begun(trials: Sequence[tuple[int, int, int]], name: str) -> tuple[_Wide, _Wide]:
    """What the seeds of streams give their generators: where to begin, and what every step adds; shape (trials,)."""
    paths = [f"{seed}/rep/{repetition}/trial/{trial}/{name}" for seed, repetition, trial in trials]
    seeds = np.frombuffer(b"".join([hashlib.sha256(path.encode()).digest()[:16] for path in paths]), dtype="<u4")
    pool = _hashed(seeds.reshape(-1, _POOL).T.astype(np.uint32, order="C"), _FILL)
    for of, constants in enumerate(_STIR):  # every word of a seed acts on every word of its pool
        mixed: _Words = _LEFT * pool - _RIGHT * _hashed(pool[of], constants)
        mixed ^= mixed >> _SHIFT
        mixed[of] = pool[of]
        pool = mixed
    words = _hashed(np.concatenate([pool, pool]), _DRAW).astype(np.uint64)
    first_high, first_low, high, low = words[::2] | words[1::2] << _HALF
    return (first_high, first_low), (high << _ONE | low >> np.uint64(63), low << _ONE | _ONE)


def _hashed(words: _Words, constants: tuple[_Words, _Words]) -> _Words:
    """The words, one row for each hash, or one for all of them, hashed."""
    hashed: _Words = (words ^ constants[0]) * constants[1]
    return hashed ^ hashed >> _SHIFT


def _states(begun: tuple[_Wide, _Wide], first: int, count: int) -> _Wide:
    """The states of generators after ``first`` numbers and those that follow, shape (count, trials).

    A step multiplies the state by the factor and adds. Before the first number a generator takes two: one from 0, and
    one after it has added where to begin. So after n numbers the state is ``begin * factor**(n + 1)`` plus
    ``added * (1 + factor + ... + factor**(n + 1))``.
    """
    begin, added = begun
    powers, sums = _multiples(first, count)
    (high, low), (more_high, more_low) = _product(begin, powers), _product(added, sums)
    total = low + more_low
    return high + more_high + (total < low), total


@lru_cache(maxsize=8)
def _multiples(first: int, count: int) -> tuple[_Wide, _Wide]:
    """Powers of the factor, and their sums, modulo 2**128, for :func:`_states`, shape (count, 1)."""
    power, total = 1, 1
    powers, sums = list[int](), list[int]()
    for _ in range(first + count):
        power = power * _FACTOR % 2**128
        total = (total + power) % 2**128
        powers.append(power)
        sums.append(total)
    return _halved(powers[first:]), _halved(sums[first:])


def _halved(numbers: Sequence[int]) -> _Wide:
    halves = np.array([[number >> 64, number % 2**64] for number in numbers], dtype=np.uint64)
    return halves[:, :1], halves[:, 1:]


def _product(one: _Wide, other: _Wide) -> _Wide:
    """The products of numbers of 128 bits, modulo 2**128."""
    (high, low), (other_high, other_low) = one, other
    upper, lower = low >> _HALF, low & _LOW_HALF
    other_upper, other_lower = other_low >> _HALF, other_low & _LOW_HALF
    crossed = upper * other_lower
    middle = (lower * other_lower >> _HALF) + (crossed & _LOW_HALF) + lower * other_upper
    carried = upper * other_upper + (crossed >> _HALF) + (middle >> _HALF)
    return carried + high * other_low + low * other_high, low * other_low
