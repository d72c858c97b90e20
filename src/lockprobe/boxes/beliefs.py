"""Bayesian beliefs about interlocks: priors, and the exact posterior over interlocks, configurations and flips.

All interlocks of a prior have equal weight. Joints are numbers; the target is joint 0. A configuration is a number
whose bit j says that joint j is "open" (away from its start). In every interlock, a joint is always free or depends on
the position of one other joint:

* ``chains``: the target needs another joint open, that one the next, and so on through all; the last is free. The
  orders of the only public code of this lineage (Baum et al., IROS 2017), 6 for 4 joints.
* ``single-parent``: every joint is free or needs one other open; 142 for 4 joints.
* ``any-literal``: every joint is free or needs one other in one of its two positions; 2152 for 4 joints.

Interlocks under which the target can never move are left out (114 of 256, 249 of 2401). A box with two conditions on
one joint is in none of these priors, so its reports can be impossible for an observer.

Under each interlock the attempts determine the configuration and the number of false reports. The posterior is the
prior times the probability of these counts:

* ``naive``: every report is true; only interlocks without a false report remain.
* a number p: every report is false with probability p, independently; k false ones of t have p^k (1 - p)^(t - k).
* ``aware``: p is unknown, with a uniform prior over [0, 1], and inferred jointly; k of t have k! (t - k)! / (t + 1)!.

The content of a report depends on the reading of a false report (:mod:`lockprobe.interventions.flip`):

* ``memoryless`` and ``latched``: the position told of the attempted joint, with the outcome told, gives its position
  before. With positions and no outcomes (``tell=state``) a report is false if the position told of the attempted joint
  is, whatever comparing it with the last report says.
* ``re-observed`` and ``integrated``: the position told of the attempted joint is the one told before, moved or not as
  the outcome says. It says no more than the outcome, which ``tell=state`` tells by this comparison.
* The other positions are true under ``memoryless`` and ``re-observed``; under ``latched`` and ``integrated`` they
  repeat what was told before.

Without positions there is the outcome alone. An observer who knows only that outcomes are inverted infers from equal
odds whether false positions stay (``re-observed`` or ``integrated``), and so does one who knows that positions are
(``memoryless`` or ``latched``). A naive one takes every position as true. A trial that goes on shows that the target
has not moved, whatever was reported.

If no interlock of the prior allows the reports, the observer keeps only the last report. It restarts from the prior at
the configuration told before it (or the most probable one, if none was told). If that is impossible too, it restarts at
the configuration told after it. Interlocks that cannot be solved from there are left out.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from itertools import pairwise, permutations, product
from math import factorial, inf, lgamma, log
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice

MOST_INTERLOCKS = 20_000
"""The largest prior that is built."""

NEVER = 255
"""The distance of configurations from which the target can never move."""

Need = tuple[int, int] | None
"""The other joint that a joint needs, and its position; None for a joint that is free."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Interlocks:
    """The interlocks of one prior over n joints.

    Attributes:
        needs: The condition of every joint, one tuple of n per interlock.
        asks: Bit mask of the joint that a condition reads, shape (interlocks, n); 0 for a free joint.
        finds: The value that the masked bit must have, of the same shape.
        distance: Fewest steps that solve the box from every configuration, shape (interlocks, 2**n); 255 if it is
            unsolvable.
    """

    prior: str
    joints: int
    needs: tuple[tuple[Need, ...], ...]
    asks: NDArray[np.int64]
    finds: NDArray[np.int64]
    distance: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.needs)

    def may_move(self, configuration: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether each joint may move in the configuration of each interlock: from (..., interlocks) to (..., n)."""
        allowed: NDArray[np.bool_] = (configuration[..., None] & self.asks) == self.finds
        return allowed

    @cached_property
    def masks(self) -> tuple[tuple[int, ...], ...]:
        """The interlocks that let each joint move in each configuration, bit s for interlock s."""
        return tuple(
            tuple(as_mask(column) for column in self.may_move(np.full(len(self), c, dtype=np.int64)).T)
            for c in range(1 << self.joints)
        )


def as_mask(chosen: NDArray[np.bool_]) -> int:
    """A choice of interlocks as a number, bit s for interlock s."""
    return int.from_bytes(np.packbits(chosen, bitorder="little").tobytes(), "little")


PRIORS = ("chains", "single-parent", "any-literal")
"""Names of the stated priors."""


@cache
def interlocks(prior: str, joints: int) -> Interlocks:
    """All interlocks of one of :data:`PRIORS` over 2 or more joints that can be solved from the start.

    >>> len(interlocks("single-parent", 4))
    142
    """
    positions = (1,) if prior == "single-parent" else (0, 1)
    count = factorial(joints - 1) if prior == "chains" else (1 + len(positions) * (joints - 1)) ** joints
    if count > MOST_INTERLOCKS:
        raise BadValue(
            f"prior {prior} over {joints} joints", f"{count} interlocks", f"at most {MOST_INTERLOCKS}; chains has fewer"
        )
    needs: list[tuple[Need, ...]]
    if prior == "chains":
        chains = ({a: (b, 1) for a, b in pairwise((0, *order))} for order in permutations(range(1, joints)))
        needs = [tuple(chain.get(joint) for joint in range(joints)) for chain in chains]
    else:
        others = ((other for other in range(joints) if other != joint) for joint in range(joints))
        needs = list(product(*([None, *product(one, positions)] for one in others)))
    asks = np.array([[need[0] + 1 if need else 0 for need in row] for row in needs], dtype=np.int64)
    bits = np.concatenate([[0], 1 << np.arange(joints, dtype=np.int64)])[asks]
    finds = np.where([[bool(need and need[1]) for need in row] for row in needs], bits, 0)
    every = np.arange(1 << joints, dtype=np.int64)
    allowed = [(every & bits[:, [joint]]) == finds[:, [joint]] for joint in range(joints)]
    distance, nearer = np.full(allowed[0].shape, NEVER), np.where(allowed[0], 1, NEVER)
    while not np.array_equal(nearer, distance):  # value iteration over all interlocks and configurations
        distance = nearer
        for joint in range(1, joints):
            beyond = np.where(allowed[joint], distance[:, every ^ (1 << joint)] + 1, NEVER)
            nearer = np.minimum(nearer, beyond)
    solvable = distance[:, 0] < NEVER
    return Interlocks(
        prior=prior,
        joints=joints,
        needs=tuple(row for row, kept in zip(needs, solvable.tolist(), strict=True) if kept),
        asks=bits[solvable],
        finds=finds[solvable],
        distance=distance[solvable],
    )


KnownReading = Literal["outcomes", "positions", "memoryless", "latched", "re-observed", "integrated"]
"""What a false report is, as far as an observer was told: a reading, or only what is inverted."""

_KINDS: Mapping[KnownReading, tuple[KnownReading, ...]] = {
    "outcomes": ("re-observed", "integrated"),
    "positions": ("memoryless", "latched"),
}
"""The readings that invert the same: outcomes, against what was told before, or positions."""

_TRUE_ELSEWHERE = ("memoryless", "re-observed")
"""The readings under which the positions of all joints but the attempted one are told truly."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """An observer's model of reports.

    ``p`` is the probability that a report is false, [0, 1], or None if the observer infers it. There is one kind of
    reading, or there are those that invert the same.
    """

    p: float | None
    kinds: tuple[KnownReading, ...]

    @property
    def naive(self) -> bool:
        """Whether every report is taken as true."""
        return self.p == 0.0


def noise_model(name: str, reading: KnownReading = "outcomes") -> Noise:
    """A noise model by name: ``naive``, ``aware``, or a flip probability from 0 to 1; 0 is ``naive``.

    ``reading`` is that of a false report that the observer was told; a naive observer ignores it.
    """
    try:
        p = None if name == "aware" else 0.0 if name == "naive" else float(name)
    except ValueError:
        p = inf
    if p is not None and not 0.0 <= p <= 1.0:
        raise BadValue("noise", name, "naive, aware, or a number from 0 to 1")
    check_choice("reading", reading, get_args(KnownReading))
    kinds: tuple[KnownReading, ...] = _KINDS.get(reading, (reading,))
    return Noise(p=p, kinds=("memoryless",) if p == 0.0 else kinds)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Belief:
    """An observer's belief at one moment. Beliefs with the same consequences are equal, whatever their history.

    Attributes:
        possible: Whether the reports are possible, by reading and interlock, shape (kinds, interlocks).
        configuration: The configuration under each interlock, shape (interlocks,).
        false, weights: The number of false reports under each, and its posterior probability, of the same shape.
        told: Reports since the beginning or the last restart.
        positions: The configuration as told last; None where positions are not told.
        moved: Probability that the last attempt moved its joint, [0, 1]; None before the first.
    """

    interlocks: Interlocks
    noise: Noise
    possible: NDArray[np.bool_]
    configuration: NDArray[np.int64]
    false: NDArray[np.int64]
    weights: Floats
    told: int = 0
    positions: int | None = 0
    moved: float | None = None

    @property
    def alive(self) -> int:
        """The possible interlocks as a number, bit s for interlock s."""
        return as_mask(np.any(self.possible, axis=0))

    @property
    def likeliest(self) -> int:
        """The most probable configuration; of equally probable ones the smallest."""
        return int(np.argmax(np.bincount(self.configuration, self.weights)))

    @property
    def key(self) -> Hashable:
        """What beliefs with the same consequences have in common, and no others."""
        held = self.possible.any(axis=0)
        arrays = (self.possible, self.configuration * held, self.false * held)
        told = self.told if self.noise.p is None else 0  # with a known p only differences of counts matter
        positions = None if self.positions is None else 0 if self.noise.kinds == ("memoryless",) else self.positions
        plain = (self.interlocks.prior, self.interlocks.joints, self.noise, told, positions)
        return (*plain, *(array.tobytes() for array in arrays))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Belief) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


def begin(interlocks: Interlocks, noise: Noise, configuration: int = 0, positions: int | None = 0) -> Belief:
    """The belief before the first report, or after a restart: the prior at a configuration, with reported positions."""
    solvable = interlocks.distance[:, configuration] < NEVER
    return Belief(
        interlocks=interlocks,
        noise=noise,
        possible=np.tile(solvable, (len(noise.kinds), 1)),
        configuration=np.full(len(interlocks), configuration, dtype=np.int64),
        false=np.zeros(len(interlocks), dtype=np.int64),
        weights=solvable / solvable.sum(),
        positions=positions,
    )


def update(belief: Belief, joint: int, moved: bool, positions: int | None, states_only: bool) -> Belief:
    """The posterior after a report on an attempt, given that the trial goes on.

    ``moved`` is what the report or its positions say. ``positions`` are the configuration as told afterwards, None
    where positions are not told; with ``states_only`` they are told and no outcomes.
    """
    report = joint, moved, positions, states_only
    if (found := _conditioned(belief, *report)) is not None:
        return found
    before = belief.likeliest if positions is None else positions ^ (moved << joint)
    again = begin(belief.interlocks, belief.noise, before & ~1, belief.positions)
    if (found := _conditioned(again, *report)) is not None:
        return found
    now = before & ~1 ^ (moved << joint) & ~1  # the target stays in place
    fresh = begin(belief.interlocks, belief.noise, now, positions)
    fresh = replace(fresh, moved=float(moved and joint > 0))
    blocked = ~fresh.interlocks.may_move(fresh.configuration)[:, 0]
    weights = fresh.weights * blocked
    total = float(weights.sum())
    if joint or not total:
        return fresh
    return replace(fresh, possible=fresh.possible & blocked, weights=weights / total)


def _conditioned(belief: Belief, joint: int, moved: bool, positions: int | None, states_only: bool) -> Belief | None:
    """The belief conditioned on the report and on the trial going on; None if no interlock allows it."""
    noise, told, bit = belief.noise, belief.told + 1, 1 << joint
    moves = belief.interlocks.may_move(belief.configuration)[:, joint]
    said: NDArray[np.bool_] | bool = moved  # under each interlock if only positions are told
    possible = belief.possible
    if positions is not None:
        compared = belief.configuration  # with which the report says that the attempted joint moved or not
        if noise.kinds[0] in _KINDS["outcomes"] and belief.positions is not None:
            compared = np.full_like(compared, belief.positions)
        if states_only:
            said = (compared ^ positions) & bit != 0
        seen = ~1 if noise.naive else ~0  # a naive one takes the target to be at rest, whatever is told of it
        before = positions ^ (said * bit)
        attempted = (compared ^ before) & (bit & seen)
        true = (belief.configuration ^ before) & (~bit & seen)
        repeated = 0 if belief.positions is None else (positions ^ belief.positions) & ~bit
        wrong = [attempted | (true if kind in _TRUE_ELSEWHERE else repeated) for kind in noise.kinds]
        possible = possible & (np.array(wrong) == 0)
    if joint == 0:
        possible = possible & ~moves
    false = belief.false + (moves != said)
    logs = np.where(possible.any(axis=0), _log_likelihood(noise.p, told)[false], -inf)
    if (most := float(logs.max())) == -inf:
        return None
    weights: Floats = np.exp(logs - most) * possible.sum(axis=0)
    weights /= weights.sum()
    return replace(
        belief,
        possible=possible & (weights > 0.0),
        configuration=belief.configuration ^ (moves << joint),
        false=false,
        weights=weights,
        told=told,
        positions=positions,
        moved=float(weights @ moves),
    )


@lru_cache(maxsize=4096)
def _log_likelihood(p: float | None, told: int) -> Floats:
    """The log-likelihood of 0, 1, ... false reports among ``told``, shape (told + 1,)."""
    counts = range(told + 1)
    if p is None:
        return np.array([lgamma(k + 1) + lgamma(told - k + 1) - lgamma(told + 2) for k in counts])
    odds = (log(p) if p > 0 else -inf, log(1 - p) if p < 1 else -inf)
    return np.array([sum(n * odd for n, odd in zip((k, told - k), odds, strict=True) if n) for k in counts])
