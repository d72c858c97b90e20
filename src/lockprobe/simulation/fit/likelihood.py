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

__all__ = ["BOUND", "Lapse", "Model", "Slope", "Softmax"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

BOUND = 15.0
"""Bound of the pulls. At this size a choice is three million times as likely; larger pulls are indistinguishable."""

_LEAST_LAPSE = 1e-9
_TINY = 1e-300


class Slope(NamedTuple):
    """A log-likelihood with its score and information matrix.

    Attributes:
        terms: Log-probability of each choice, shape (choices,).
        scores: Their derivatives by the parameters, shape (choices, parameters).
        information: Information matrix of the sum, shape (parameters, parameters), positive semi-definite.
    """

    terms: Array
    scores: Array
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
        """The log-likelihood with score and information."""

    def at(self, rows: Flags) -> Model:
        """The model of a subset of the choices, by a boolean array of shape (choices,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Softmax:
    """A softmax (conditional logit): P(joint j) is proportional to exp(sum over k of pull k times feature k of j).

    With ``traces`` the last two parameters are ``decay`` and ``reset``, and the feature called ``failure`` is minus
    the failure trace ``decay ** age * (1 - reset) ** moves`` of :class:`lockprobe.agents.cognitive.SoftmaxMemory`.

    Attributes:
        names: Names of the pulls.
        features: Shape (choices, joints, pulls).
        chosen: Shape (choices,).
        present: Whether each joint exists, shape (choices, joints).
        traces: Age of each joint's last failure (-1: none) and perceived moves since; None without ``failure``.
    """

    names: tuple[str, ...]
    features: Array
    chosen: Integers
    present: Flags
    traces: tuple[Integers, Integers] | None = None

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
        return self._softmax(self._design(values), values)

    def slope(self, values: Array) -> Slope:
        """The log-likelihood; the information matrix is the expected one, given the reports."""
        design = self._design(values)
        chances = self._softmax(design, values)
        rows = np.arange(len(self.chosen))
        mean = np.einsum("cj,cjk->ck", chances, design)
        flat = design.reshape(chances.size, -1) if len(values) else np.empty((chances.size, 0))
        return Slope(
            terms=np.log(np.maximum(chances[rows, self.chosen], _TINY)),
            scores=design[rows, self.chosen] - mean,
            information=(flat * chances.reshape(-1, 1)).T @ flat - mean.T @ mean,
        )

    def at(self, rows: Flags) -> Softmax:
        """The same for some of the choices."""
        return replace(
            self,
            features=self.features[rows],
            chosen=self.chosen[rows],
            present=self.present[rows],
            traces=(self.traces[0][rows], self.traces[1][rows]) if self.traces else None,
        )

    def _softmax(self, design: Array, values: Array) -> Array:
        pulls = np.where(self.present, design[:, :, : len(self.names)] @ values[: len(self.names)], -np.inf)
        weights = np.exp(pulls - pulls.max(axis=1, keepdims=True))
        chances: Array = weights / weights.sum(axis=1, keepdims=True)
        return chances

    def _design(self, values: Array) -> Array:
        """Derivatives of the summed pulls, shape (choices, joints, parameters)."""
        if self.traces is None:
            return self.features
        (age, moves), (decay, reset) = self.traces, values[-2:]
        powers = np.arange(max(age.max(initial=0), moves.max(initial=0)) + 1)
        fading, kept = decay**powers, (1 - reset) ** powers
        ever, steps, earlier = age >= 0, np.maximum(age, 0), np.maximum(age - 1, 0)
        place = self.names.index("failure")
        design = np.empty((*age.shape, len(self.names) + 2))
        design[:, :, :-2] = self.features
        design[:, :, place] = -1.0 * ever * fading[steps] * kept[moves]
        design[:, :, -2] = -values[place] * ever * steps * fading[earlier] * kept[moves]
        design[:, :, -1] = values[place] * ever * fading[steps] * moves * kept[np.maximum(moves - 1, 0)]
        return design


@dataclass(frozen=True, slots=True, kw_only=True)
class Lapse:
    """A rule with lapses: in a share ``lapse`` of choices all joints are equally likely.

    Attributes:
        follows: Probabilities by the rule alone, shape (choices, joints).
        chosen: Shape (choices,).
        present: Whether each joint exists, shape (choices, joints).
    """

    follows: Array
    chosen: Integers
    present: Flags

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
        return lapse * chance + (1 - lapse) * self.follows

    def slope(self, values: Array) -> Slope:
        """The log-likelihood; the information matrix is the observed one."""
        chance = 1 / self.present.sum(axis=1)
        likely = values[0] * chance + (1 - values[0]) * self._followed
        scores = ((chance - self._followed) / likely)[:, None]
        return Slope(terms=np.log(likely), scores=scores, information=scores.T @ scores)

    def at(self, rows: Flags) -> Lapse:
        """The same for some of the choices."""
        return Lapse(follows=self.follows[rows], chosen=self.chosen[rows], present=self.present[rows])
