"""Fractional factorial designs of two levels: which combinations to play, and which factors conditions cross.

In a design of resolution IV no main effect is mixed with another one, or with an interaction of two factors. Two-factor
interactions are mixed with each other (Box, Hunter and Hunter, *Statistics for Experimenters*, 2005, ch. 6).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from math import prod

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.conditions.series import SeriesArm

_BASE = 4
"""Factors whose combinations are all played; the others follow from three of them each."""

_FEWEST = 3
"""Fewest factors of a factorial design; two are a crossing."""


def fraction(factors: int) -> list[tuple[int, ...]]:
    """The levels of 4 to 8 factors in 16 combinations of resolution IV, -1 or 1; the first is -1 throughout.

    >>> runs = fraction(8)
    >>> len(runs), runs[0], {sum(column) for column in zip(*runs)}
    (16, (-1, -1, -1, -1, -1, -1, -1, -1), {0})
    """
    thirds = list(combinations(range(_BASE), 3))[: factors - _BASE]
    return [(*base, *(prod(base[i] for i in third) for third in thirds)) for base in product((-1, 1), repeat=_BASE)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Factorial:
    """A balanced design among the conditions of one modality.

    Attributes:
        modality: How the box is shown, without doses.
        factors: Names of the factors.
        levels: Factor -> what its low and its high level are called.
        runs: Label of a condition -> its level of each factor, -1 or 1.
    """

    modality: str
    factors: tuple[str, ...]
    levels: Mapping[str, tuple[str, str]]
    runs: Mapping[str, tuple[int, ...]]


def factorials_of(arms: Sequence[SeriesArm], modality: str) -> list[Factorial]:
    """The factorial designs among conditions: none or one, of options that are left out or have one other value.

    Every two factors have to be orthogonal: their four combinations occur equally often.
    """
    shown = [arm for arm in arms if arm.modality == modality]
    said = {arm.label: dict(option for i in arm.acting for option in _of(arm.specs[i])) for arm in shown}
    values: dict[str, set[str]] = {}
    for options in said.values():
        for name, value in options.items():
            values.setdefault(name, set()).add(value)
    factors = tuple(name for name, found in values.items() if len(found) == 1)
    if len(factors) < _FEWEST or len(factors) < len(values):
        return []
    runs = {label: tuple(1 if name in options else -1 for name in factors) for label, options in said.items()}
    columns = list(zip(*runs.values(), strict=True))
    balanced = all(sum(column) == 0 for column in columns)
    if not balanced or any(sum(map(prod, zip(*two, strict=True))) for two in combinations(columns, 2)):
        return []
    levels = {name: ("", *values[name]) for name in factors}
    return [Factorial(modality=modality, factors=factors, levels=levels, runs=runs)]  # type: ignore[arg-type]


def _of(spec: Spec) -> list[tuple[str, str]]:
    """The options of an intervention; one without options is an option itself."""
    return [(f"{spec.full_name}.{name}", value) for name, value in spec.options.items()] or [(spec.full_name, "yes")]
