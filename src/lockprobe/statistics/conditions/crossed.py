"""Crossed conditions: two interventions with and without each other, or two doses in all their combinations.

Their interaction is the *linear-by-linear contrast* of all cells: the least-squares slope over the product of both
doses in a model with an effect for every row and column. It is scaled to the whole range: how much more the highest
dose of one changes success at the highest than at the lowest dose of the other. In a two-by-two grid it is the
difference of differences.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.conditions.axis import Axis, SeriesArm


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossed:
    """Conditions that differ only in two doses, or in whether two interventions act.

    Attributes:
        conditions: (First dose, second dose) -> condition, ascending; combinations that are not played are missing.
            Dose 0 is without the intervention, dose 1 with one that is crossed whole. Of two doses of one intervention
            there is no 0: without it, neither has a value.
        axes: Both doses; none if interventions are crossed whole.
    """

    conditions: Mapping[tuple[float, float], str]
    modality: str
    axes: tuple[Axis, ...] = ()

    @property
    def doses(self) -> tuple[list[float], list[float]]:
        """The first doses and the second ones, ascending."""
        rows, columns = (sorted(set(of)) for of in zip(*self.conditions, strict=True))
        return rows, columns

    @property
    def weights(self) -> dict[str, int]:
        """The weight of each condition in the interaction; none if a combination is not played."""
        if len(self.conditions) < math.prod(map(len, self.doses)):
            return {}
        return dict(zip(self.conditions.values(), trend_weights(*self.doses)[0], strict=True))

    @property
    def factor(self) -> float:
        """What the weighted sum is multiplied with."""
        return float(trend_weights(*self.doses)[1])


def crossed_of(arms: Sequence[SeriesArm]) -> Iterator[Crossed]:
    """What the conditions of one modality cross: interventions, then doses of two or more levels, all else equal."""
    known: dict[tuple[str, ...], str] = {}
    for arm in arms:
        known.setdefault(arm.without(), arm.label)
    for arm in arms:
        for i, j in combinations(arm.acting, 2):
            away = {(0.0, 0.0): (i, j), (0.0, 1.0): (i,), (1.0, 0.0): (j,), (1.0, 1.0): ()}
            if all(arm.without(*places) in known for places in away.values()):
                conditions = {at: known[arm.without(*places)] for at, places in away.items()}
                yield Crossed(conditions=conditions | {(1.0, 1.0): arm.label}, modality=arm.modality)
    pairs = ((arm, one, other) for arm in arms for one, other in combinations(arm.dosed, 2))
    for members in grouped(pairs, lambda member: member[0].family(*member[1:])).values():
        # a dose that no condition says as a number, but a word that stands for one, makes a factor
        said = all(any(arm.says(*pair[of]) for arm, *pair in members) for of in (0, 1))
        if said and min(map(len, (grid := _grid(members, known)).doses)) > 1:
            yield grid


_Dose = tuple[int, str]
"""The place of an intervention, and the name of a dose of it."""


def _grid(members: Sequence[tuple[SeriesArm, _Dose, _Dose]], known: Mapping[tuple[str, ...], str]) -> Crossed:
    first, *pair = members[0]
    i, j = (at for at, _ in pair)
    found: dict[tuple[float, float], str] = {}
    for arm, one, other in members:
        row, column = arm.dose(*one), arm.dose(*other)
        found.setdefault((row, column), arm.label)
        for place, (away, option) in (((row, 0.0), other), ((0.0, column), one)):
            zero = i != j and option == arm.doses[away][0]  # without an intervention it has no second dose either
            if zero and (alone := known.get(arm.without(away))):
                found.setdefault(place, alone)
    neither = known.get(first.without(i, j)) if i != j else None
    if neither and any(row == 0 for row, _ in found) and any(column == 0 for _, column in found):
        found.setdefault((0.0, 0.0), neither)
    rest = " + ".join(first.without(i, j))
    axes = tuple(Axis(kind=first.specs[at].full_name, dose=option, rest=rest) for at, option in pair)
    return Crossed(conditions=dict(sorted(found.items())), modality=first.modality, axes=axes)


def trend_weights(row_doses: Sequence[float], column_doses: Sequence[float]) -> tuple[list[int], Fraction]:
    """The weights of all cells in the linear-by-linear contrast, as whole numbers, and their common factor.

    >>> trend_weights((0, 0.4), (0, 0.1))
    ([1, -1, -1, 1], Fraction(1, 1))
    >>> trend_weights((0, 0.1, 0.2), (0, 0.1))
    ([1, -1, 0, 0, -1, 1], Fraction(1, 1))

    Weights are by row, then by column. Doses are ascending, at least two.
    """
    (rows, one), (columns, other) = _trend(row_doses), _trend(column_doses)
    return [row * column for row, column in product(rows, columns)], one * other


def _trend(doses: Sequence[float]) -> tuple[list[int], Fraction]:
    """The weights of the least-squares slope times the range of the doses."""
    exact = [Fraction(str(dose)) for dose in doses]
    away = [dose - sum(exact, Fraction(0)) / len(exact) for dose in exact]
    most = math.lcm(*(one.denominator for one in away))
    whole = [int(one * most) for one in away]
    common = math.gcd(*whole)
    factor = (exact[-1] - exact[0]) * common / most / sum((one * one for one in away), Fraction(0))
    return [one // common for one in whole], factor
