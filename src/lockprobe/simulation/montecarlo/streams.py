"""The random number streams of the trials of a population.

They come either from a study's tree of seeds, so that trial 7 equals trial 7 of that study, or from a counter-based
generator, which is far faster. Both give common random numbers: a trial has the same numbers at every flip rate and for
every agent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.box import Lockbox, Shuffle
from lockprobe.foundation.seeds import generator, trial_stream
from lockprobe.simulation.montecarlo.compiled import SPAN, below, joints_in, uniform
from lockprobe.simulation.montecarlo.rules import Integers, Numbers
from lockprobe.trial.plan import drawn_orders, orders_of_study

OF_FLIPS = SPAN // 2
OF_LISTING = SPAN - 8
"""Offsets of the random numbers of the outcome flip and of the listing; the agent's come first."""


class Luck(NamedTuple):
    """The random numbers of one trial: the order of the listing, and the streams of outcome flip and agent."""

    order: tuple[int, ...]
    channel: np.random.Generator
    agent: np.random.Generator


class LuckBlock(NamedTuple):
    """The random numbers of several trials, one row each: orders of the listing, flips, and draws of the agent."""

    orders: Integers
    flips: Numbers
    draws: Numbers


class LuckSource(Protocol):
    """A source of random numbers for trials, which are counted from 0."""

    def luck(self, trial: int) -> Luck:
        """The random numbers of one trial."""
        ...

    def block(self, first: int, trials: int) -> LuckBlock:
        """The random numbers of this many trials, from ``first`` on."""
        ...


def order_of(box: Lockbox, shuffle: Shuffle, seed: int) -> tuple[int, ...] | None:
    """The order in which the joints of a box, in panel order, are always listed; None if each trial draws one."""
    if shuffle == "trial":
        return None
    return orders_of_study(box, seed)[1] if shuffle == "study" else tuple(range(len(box.joints)))


@dataclass(frozen=True, slots=True)
class FromTree:
    """The random streams of a study's trials, equal to those of :class:`lockprobe.trial.plan.Plan`.

    Attributes:
        seed: Seed of the study.
        repetition: Repetition of the study, from 1.
        joints: Number of joints listed.
        order: The order in which they are listed in every trial; None if one is drawn for each.
        flips: Random numbers of the outcome flip per trial of a block.
        draws: Random numbers of the agent per trial of a block.
    """

    seed: int
    repetition: int
    joints: int
    _: KW_ONLY
    order: tuple[int, ...] | None
    flips: int
    draws: int

    def luck(self, trial: int) -> Luck:
        """The random numbers of one trial, as unlimited streams."""
        return Luck(
            order=self._order(trial), channel=self._stream(trial, "channel-0"), agent=self._stream(trial, "agent")
        )

    def block(self, first: int, trials: int) -> LuckBlock:
        """The first numbers of many trials' streams."""
        return LuckBlock(
            orders=np.array([self._order(trial) for trial in range(first, first + trials)], np.int64),
            flips=self._numbers(first, trials, "channel-0", self.flips),
            draws=self._numbers(first, trials, "agent", self.draws),
        )

    def _numbers(self, first: int, trials: int, name: str, count: int) -> Numbers:
        numbers = np.empty((trials, count))
        for i in range(trials if count else 0):
            numbers[i] = self._stream(first + i, name).random(count)
        return numbers

    def _stream(self, trial: int, name: str) -> np.random.Generator:
        return trial_stream(self.seed, self.repetition, trial + 1, name)

    def _order(self, trial: int) -> tuple[int, ...]:
        return self.order or drawn_orders(self.joints, self._stream(trial, "labels"))[1]


@dataclass
class Counted:
    """Counter-based random numbers: trial t has outputs ``t * SPAN``, ``t * SPAN`` + 1, ... of one SplitMix64.

    No two trials share a number, and no number depends on the order of play or on threads.

    Attributes:
        seed: Any integer.
        joints: Number of joints listed.
        order: The order in which they are listed in every trial; None if one is drawn for each.
        flips: Random numbers of the outcome flip per trial.
        draws: Random numbers of the agent per trial.
        depth: For the uniformly random agent, the number of steps per random number; else 0.
        fill: :func:`lockprobe.simulation.montecarlo.compiled.fill`, compiled.
    """

    seed: int
    joints: int
    _: KW_ONLY
    order: tuple[int, ...] | None
    flips: int
    draws: int
    depth: int = 0
    fill: Callable[[np.uint64, int, int, Numbers], None] | None = None

    def __post_init__(self) -> None:
        self.key: np.uint64 = generator(self.seed, "population").integers(2**64, dtype=np.uint64)

    def luck(self, trial: int) -> Luck:
        """The random numbers of one trial."""
        block = self.block(trial, 1)
        channel, agent = (cast("np.random.Generator", _FixedStream(numbers[0])) for numbers in block[1:])
        return Luck(order=tuple(map(int, block.orders[0])), channel=channel, agent=agent)

    def block(self, first: int, trials: int) -> LuckBlock:
        """The random numbers of this many trials, from ``first`` on."""
        if self.order is None:
            orders = np.argsort(self._numbers(first, trials, OF_LISTING, self.joints), axis=1)
        else:
            orders = np.tile(self.order, (trials, 1))
        return LuckBlock(
            orders=orders,
            flips=self._numbers(first, trials, OF_FLIPS, self.flips),
            draws=self._joints_drawn(first, trials) if self.depth else self._numbers(first, trials, 0, self.draws),
        )

    def _numbers(self, first: int, trials: int, offset: int, count: int) -> Numbers:
        if self.fill is None:
            numbers: Numbers = uniform(self.key, _places(first, trials, offset, count))
            return numbers
        numbers = np.empty((trials, count))
        self.fill(self.key, first, offset, numbers)
        return numbers

    def _joints_drawn(self, first: int, trials: int) -> Numbers:
        """Random numbers with which the agent takes the same joints as in ``play_blind``."""
        sequences = joints_in(self.joints, self.depth)
        outputs = _places(first, trials, 0, -(-self.draws // self.depth))
        taken = sequences[below(self.key, outputs, np.uint64(len(sequences)))]
        numbers: Numbers = (taken.reshape(trials, -1)[:, : self.draws] + 0.5) / self.joints
        return numbers


def _places(first: int, trials: int, offset: int, count: int) -> NDArray[np.uint64]:
    """The counter values of numbers ``offset``, ``offset`` + 1, ... of some trials."""
    starts = np.arange(first, first + trials, dtype=np.uint64)[:, None] * np.uint64(SPAN)
    return np.asarray(starts + np.arange(offset, offset + count, dtype=np.uint64), np.uint64)


class _FixedStream:
    """A stream of given numbers."""

    def __init__(self, numbers: Numbers) -> None:
        self._numbers = iter(numbers.tolist())

    def random(self) -> float:
        return float(next(self._numbers))
