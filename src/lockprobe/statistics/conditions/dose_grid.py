"""Crossed doses: two doses, of two interventions or of one, in all their combinations.

Their interaction is the *linear-by-linear contrast* of all cells: the least-squares slope over the product of both
doses in a model with an effect for every row and column. It is scaled to the whole range: how much more the highest
dose of one changes success at the highest than at the lowest dose of the other. In a two-by-two grid it is the
difference of differences.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product

from lockprobe.statistics.conditions.axis import Axis
from lockprobe.statistics.conditions.series import SeriesArm


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A grid of conditions that differ only in two doses.

    Attributes:
        rows, columns: The axes of the first and the second dose.
        row_doses, column_doses: Their doses, ascending; dose 0 means without the intervention. Of two doses of one
            intervention there is none: without it, neither has a value.
        conditions: (Row dose, column dose) -> condition; combinations that are not played are missing.
        modality: How the box is shown in all of them.
    """

    rows: Axis
    columns: Axis
    row_doses: tuple[float, ...]
    column_doses: tuple[float, ...]
    conditions: Mapping[tuple[float, float], str]
    modality: str

    @property
    def weights(self) -> dict[str, int]:
        """The weight of each condition in the interaction; none if a combination is not played."""
        if len(self.conditions) < len(self.row_doses) * len(self.column_doses):
            return {}
        return dict(zip(self.conditions.values(), trend_weights(self.row_doses, self.column_doses)[0], strict=True))

    @property
    def factor(self) -> float:
        """What the weighted sum is multiplied with."""
        return float(trend_weights(self.row_doses, self.column_doses)[1])

    @property
    def name(self) -> str:
        """Both doses, as sentences and figures name them."""
        return f"{self.rows.name} \N{MULTIPLICATION SIGN} {self.columns.name}"


def grids(arms: Sequence[SeriesArm]) -> tuple[Grid, ...]:
    """The grids of a study: pairs of doses with two or more levels each, in the order of conditions.

    Args:
        arms: The conditions of a study. Each modality, and each set of other interventions, makes a separate grid.
    """
    known: dict[tuple[str, tuple[str, ...]], str] = {}
    for arm in arms:
        known.setdefault((arm.modality, arm.without()), arm.label)
    families: dict[tuple[object, ...], list[_Crossed]] = {}
    for arm in arms:
        for pair in combinations(arm.dosed, 2):
            families.setdefault(arm.family(*pair), []).append((arm, *pair))
    made = (_grid(members, known) for members in families.values() if _says_both(members))
    return tuple(grid for grid in made if min(len(grid.row_doses), len(grid.column_doses)) > 1)


_Dose = tuple[int, str]
"""The place of an intervention, and the name of a dose of it."""

_Crossed = tuple[SeriesArm, _Dose, _Dose]


def _says_both(members: Sequence[_Crossed]) -> bool:
    """Whether each of both doses is said as a number by a condition; a word that stands for one makes a factor."""
    return all(any(arm.says(*pair[of]) for arm, *pair in members) for of in (0, 1))


def _grid(members: Sequence[_Crossed], known: Mapping[tuple[str, tuple[str, ...]], str]) -> Grid:
    first, *pair = members[0]
    i, j = (at for at, _ in pair)
    shown, rest = first.modality, " + ".join(first.without(i, j))
    found: dict[tuple[float, float], str] = {}
    for arm, one, other in members:
        row, column = arm.dose(*one), arm.dose(*other)
        found.setdefault((row, column), arm.label)
        for place, (away, option) in (((row, 0.0), other), ((0.0, column), one)):
            zero = i != j and option == arm.doses[away][0]  # without an intervention it has no second dose either
            alone = known.get((shown, arm.without(away))) if zero else None
            if alone:
                found.setdefault(place, alone)
    neither = known.get((shown, first.without(i, j))) if i != j else None
    if neither and any(row == 0 for row, _ in found) and any(column == 0 for _, column in found):
        found.setdefault((0.0, 0.0), neither)
    rows, columns = (Axis(kind=first.specs[at].full_name, dose=option, rest=rest) for at, option in pair)
    return Grid(
        rows=rows,
        columns=columns,
        row_doses=tuple(sorted({row for row, _ in found})),
        column_doses=tuple(sorted({column for _, column in found})),
        conditions=dict(sorted(found.items())),
        modality=shown,
    )


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
