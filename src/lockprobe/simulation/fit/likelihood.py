"""The likelihood of an agent's choices under a model with free parameters, and its derivatives.

A :class:`Softmax` weighs joints by a sum of pulls; with fixed traces it is a conditional logit (McFadden 1974) and
concave in the pulls. A :class:`Lapse` follows a rule except for a share of its choices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.fit.situations import Situations

__all__ = ["BOUND", "Lapse", "Model", "Slope", "Softmax", "Traces"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

BOUND = 15.0
"""Bound of the pulls. At this size a choice is three million times as likely; larger pulls are indistinguishable."""

_LEAST_LAPSE = 1e-9
_TINY = 1e-300


class Slope(NamedTuple):
    """The log-likelihood of some choices with its derivatives.

    Attributes:
        log_likelihood: The log-likelihood, natural logarithm.
        uphill: Its derivatives by the parameters, shape (parameters,).
        information: The information matrix, shape (parameters, parameters), positive semi-definite.
    """

    log_likelihood: float
    uphill: Array
    information: Array


class Model(Protocol):
    """A parametric model of choices."""

    @property
    def bounds(self) -> Mapping[str, tuple[float, float]]:
        """Lower and upper bound of each parameter, in order."""

    @property
    def starts(self) -> tuple[tuple[float, ...], ...]:
        """Starting values for the search of the maximum."""

    def probabilities(self, values: Array) -> Array:
        """The probability of each joint at each choice, shape (choices, joints)."""

    def slope(self, values: Array) -> Slope:
        """The log-likelihood with its derivatives and the information matrix."""

    def scores(self, values: Array) -> Array:
        """Derivatives of the log-probability of each choice by the parameters, shape (choices, parameters)."""

    def at(self, rows: Flags) -> Model:
        """The model of a subset of the choices, by a boolean array of shape (choices,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Traces:
    """What the failure trace of a joint depends on, in all pairs of age and moves that occur.

    Attributes:
        age: Steps since the joint's last failure, 0 for the step before; -1 if it never failed. Shape (pairs,).
        moves: Perceived moves since, 0 if it never failed. Shape (pairs,).
        pair: The pair of each joint in each situation, shape (joints, situations).
    """

    age: Integers
    moves: Integers
    pair: Integers

    def at(self, kept: Integers | Flags) -> Traces:
        """The same for some of the situations."""
        return replace(self, pair=self.pair[:, kept])

    def faded(self, decay: float, reset: float) -> tuple[Array, Array, Array]:
        """The traces and their derivatives by ``decay`` and ``reset``, each of shape (joints, situations)."""
        ever, steps, moves, kept = self.age >= 0, np.maximum(self.age, 0), self.moves, 1 - reset
        trace = ever * decay**steps * kept**moves
        by_decay = ever * steps * decay ** np.maximum(steps - 1, 0) * kept**moves
        by_reset = -1.0 * ever * decay**steps * moves * kept ** np.maximum(moves - 1, 0)
        return trace[self.pair], by_decay[self.pair], by_reset[self.pair]


@dataclass(frozen=True, slots=True, kw_only=True)
class Softmax:
    """A softmax (conditional logit): P(joint j) is proportional to exp(sum over k of pull k times feature k of j).

    With ``traces`` the last two parameters are ``decay`` and ``reset``, and the feature called ``failure`` is minus
    the failure trace ``decay ** age * (1 - reset) ** moves`` of :class:`lockprobe.agents.cognitive.SoftmaxMemory`.

    Attributes:
        names: Names of the pulls.
        situations: The situations of the choices.
        features: Shape (pulls, joints, situations).
        chosen: Shape (situations,).
        present: Whether each joint exists, shape (joints, situations).
        traces: The failure traces; None without ``failure``.
    """

    names: tuple[str, ...]
    situations: Situations
    features: Array
    chosen: Integers
    present: Flags
    traces: Traces | None = None

    @classmethod
    def of(
        cls,
        names: tuple[str, ...],
        features: Array,
        chosen: Integers,
        present: Flags,
        traces: tuple[Integers, Integers] | None = None,
    ) -> Softmax:
        """The softmax of some choices.

        Args:
            names: Names of the pulls.
            features: Shape (choices, joints, pulls).
            chosen: Shape (choices,).
            present: Whether each joint exists, shape (choices, joints).
            traces: Age of each joint's last failure (-1: none) and perceived moves since; None without ``failure``.
        """
        faded = None
        if traces is not None:
            age, moves = traces[0], np.where(traces[0] < 0, 0, traces[1])
            base = moves.max(initial=0) + 1
            pairs, pair = np.unique((age + 1) * base + moves, return_inverse=True)
            pair = pair.reshape(age.shape)
            faded = Traces(age=pairs // base - 1, moves=pairs % base, pair=pair.T)
        columns = [features, chosen, present] if faded is None else [features, chosen, present, faded.pair.T]
        situations, first = Situations.of(*columns)
        return cls(
            names=names,
            situations=situations,
            features=np.ascontiguousarray(features[first].transpose(2, 1, 0)),
            chosen=chosen[first],
            present=np.ascontiguousarray(present[first].T),
            traces=faded.at(first) if faded else None,
        )

    @property
    def bounds(self) -> Mapping[str, tuple[float, float]]:
        """Pulls within :data:`BOUND`, shares within [0, 1]."""
        shares = {"decay": (0.0, 1.0), "reset": (0.0, 1.0)} if self.traces else {}
        return dict.fromkeys(self.names, (-BOUND, BOUND)) | shares

    @property
    def starts(self) -> tuple[tuple[float, ...], ...]:
        """Pulls of 0, with short and long memories that a move does or does not reset."""
        memories = [(0.3, 0.5), (0.9, 0.1), (0.9, 0.9), (1.0, 1.0)] if self.traces else [()]
        return tuple((*[0.0] * len(self.names), *memory) for memory in memories)

    def probabilities(self, values: Array) -> Array:
        """The softmax of the pulls."""
        return np.ascontiguousarray(self._softmax(self._design(values), values).T[self.situations.which])

    def slope(self, values: Array) -> Slope:
        """The log-likelihood; the information matrix is the expected one, given the reports."""
        counts, design = self.situations.counts, self._design(values)
        chances = self._softmax(design, values)
        mean = _mean(design, chances)
        terms = np.log(np.maximum(self._of_chosen(chances), _TINY))
        information = -(mean * counts) @ mean.T
        for joint, weights in enumerate(chances * counts):
            information += (design[:, joint] * weights) @ design[:, joint].T
        return Slope(
            log_likelihood=float((counts * terms).sum()),
            uphill=(self._of_chosen(design) - mean) @ counts,
            information=information,
        )

    def scores(self, values: Array) -> Array:
        """The chosen joint's features minus those expected."""
        design = self._design(values)
        scores = self._of_chosen(design) - _mean(design, self._softmax(design, values))
        return scores.T[self.situations.which]

    def at(self, rows: Flags) -> Softmax:
        """The same for some of the choices."""
        situations, kept = self.situations.at(rows)
        return replace(
            self,
            situations=situations,
            features=self.features[:, :, kept],
            chosen=self.chosen[kept],
            present=self.present[:, kept],
            traces=self.traces.at(kept) if self.traces else None,
        )

    def _softmax(self, design: Array, values: Array) -> Array:
        """The probability of each joint, shape (joints, situations)."""
        flat = design[: len(self.names)].reshape(len(self.names), self.present.size)
        pulls = np.where(self.present, (values[: len(self.names)] @ flat).reshape(self.present.shape), -np.inf)
        weights = np.exp(pulls - pulls.max(axis=0))
        chances: Array = weights / weights.sum(axis=0)
        return chances

    def _of_chosen(self, values: Array) -> Array:
        """Values of the joint chosen, shape (..., situations), from values of shape (..., joints, situations)."""
        flat = values.reshape(*values.shape[:-2], self.present.size)
        return flat.take(self.chosen * len(self.chosen) + np.arange(len(self.chosen)), axis=-1)

    def _design(self, values: Array) -> Array:
        """Derivatives of the summed pulls, shape (parameters, joints, situations)."""
        if self.traces is None:
            return self.features
        place = self.names.index("failure")
        design = np.empty((len(self.names) + 2, *self.present.shape))
        design[:-2] = self.features
        trace, by_decay, by_reset = self.traces.faded(values[-2], values[-1])
        design[place], design[-2], design[-1] = -trace, -values[place] * by_decay, -values[place] * by_reset
        return design


def _mean(design: Array, chances: Array) -> Array:
    """The expected features, shape (parameters, situations)."""
    mean: Array = np.einsum("kjs,js->ks", design, chances)
    return mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Lapse:
    """A rule with lapses: in a share ``lapse`` of choices all joints are equally likely.

    Attributes:
        situations: The situations of the choices.
        follows: Probabilities by the rule alone, shape (situations, joints).
        chosen: Shape (situations,).
        present: Whether each joint exists, shape (situations, joints).
    """

    situations: Situations
    follows: Array
    chosen: Integers
    present: Flags

    @classmethod
    def of(cls, follows: Array, chosen: Integers, present: Flags) -> Lapse:
        """The rule at some choices, by arrays of shape (choices, joints) and (choices,)."""
        situations, first = Situations.of(follows, chosen, present)
        return cls(situations=situations, follows=follows[first], chosen=chosen[first], present=present[first])

    @property
    def bounds(self) -> Mapping[str, tuple[float, float]]:
        """The lapse rate in [0, 1]; above 0 if some choice violates the rule."""
        return {"lapse": (0.0 if self._followed.all() else _LEAST_LAPSE, 1.0)}

    @property
    def starts(self) -> tuple[tuple[float, ...], ...]:
        """One starting value, because the log-likelihood is concave."""
        return ((0.2,),)

    @property
    def _followed(self) -> Array:
        followed: Array = self.follows[np.arange(len(self.chosen)), self.chosen]
        return followed

    def probabilities(self, values: Array) -> Array:
        """The rule mixed with chance."""
        chance: Array = self.present / self.present.sum(axis=1, keepdims=True)
        lapse = float(values[0])
        return (lapse * chance + (1 - lapse) * self.follows)[self.situations.which]

    def slope(self, values: Array) -> Slope:
        """The log-likelihood; the information matrix is the observed one."""
        counts, (likely, scores) = self.situations.counts, self._terms(values)
        return Slope(
            log_likelihood=float((counts * np.log(likely)).sum()),
            uphill=np.array([(counts * scores).sum()]),
            information=np.array([[(counts * scores**2).sum()]]),
        )

    def scores(self, values: Array) -> Array:
        """Derivatives by the lapse rate."""
        return self._terms(values)[1][self.situations.which, None]

    def at(self, rows: Flags) -> Lapse:
        """The same for some of the choices."""
        situations, kept = self.situations.at(rows)
        return Lapse(
            situations=situations, follows=self.follows[kept], chosen=self.chosen[kept], present=self.present[kept]
        )

    def _terms(self, values: Array) -> tuple[Array, Array]:
        """The probability of the joint chosen, and the derivative of its logarithm, each of shape (situations,)."""
        chance = 1 / self.present.sum(axis=1)
        likely = values[0] * chance + (1 - values[0]) * self._followed
        return likely, (chance - self._followed) / likely
