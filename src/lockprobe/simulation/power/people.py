"""How many persons a study of people needs, and what a number of persons can detect, within and between persons.

The model: a person opens a box under condition c with the logit a_c + u + v_c. u is the person's skill, normal with
standard deviation ``person_sd``. v_c is how much the person differs from others in the effect of c, normal with
standard deviation ``effect_sd``, and 0 under the control. a_c is such that the mean over persons is the stated share.
Boxes of a person are independent given u and v. Learning from box to box is not in it.

The tests: a t test on persons' differences in the share that they opened (within), and Welch's t test on persons'
shares (between), two-sided, each condition against the control, with Bonferroni's correction.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt
from typing import Literal

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.proportions import ALPHA

Design = Literal["within", "between"]

PERSON_SD = 1.0
"""The default standard deviation of skill, in logits, chosen by eye: at a mean of one half, the middle two thirds of
persons open 29 to 71 % of their boxes."""

EFFECT_SD = 0.5
"""The default standard deviation of effects between persons, in logits, chosen by eye: half of that of skill."""

FEWEST = 10
"""The fewest persons in a group that are reported: with fewer, a t test on shares of a few boxes is not reliable."""

_MOST = 1_000_000
_POINTS = 40

_EDGE = 1e-3
"""How near to 0 or 1 a share is searched, as a share of the way from there to the control."""

_EXACT = 1e-4
"""How exactly the smallest effect is found, as a share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    """The persons of a study and what each plays.

    Attributes:
        success: Share of boxes opened under each condition, the control first.
        boxes: Boxes that a person plays under each condition (within). Between, a person plays as many boxes in all,
            under one condition.
        person_sd: Standard deviation of skill between persons, in logits.
        effect_sd: Standard deviation of effects between persons, in logits.
    """

    success: tuple[float, ...]
    boxes: int = 1
    person_sd: float = PERSON_SD
    effect_sd: float = EFFECT_SD

    def __post_init__(self) -> None:
        if len(self.success) < 2 or not all(0 < share < 1 for share in self.success):
            raise BadValue("success", self.success, "two or more shares above 0 and below 1, the control first")
        if self.boxes < 1:
            raise BadValue("boxes", self.boxes, "1 or more")
        for name in ("person_sd", "effect_sd"):
            if not 0 <= getattr(self, name) <= 10:
                raise BadValue(name, getattr(self, name), "a standard deviation in logits, 0 to 10")

    @property
    def boxes_in_all(self) -> int:
        """Boxes of one person."""
        return self.boxes * len(self.success)

    @property
    def treated_sd(self) -> float:
        """Standard deviation of persons under a condition that is not the control, in logits."""
        return sqrt(self.person_sd**2 + self.effect_sd**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleNeeded:
    """Persons in all, for all comparisons of a design; ``per_condition`` of them see a condition."""

    people: int
    per_condition: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerOfPeople(PeopleNeeded):
    """What a number of persons can detect. Between persons, a remainder of them is left out.

    Attributes:
        power: The least power of the comparisons with the control.
        below: The largest share under the control's that a comparison detects with the target power; None for none.
        above: The smallest share over the control's, likewise.
    """

    power: float
    below: float | None
    above: float | None


def power_with(model: People, design: Design, people: int, target: float = 0.8) -> PowerOfPeople | None:
    """The power with so many persons in all, and the smallest effects that have the power ``target``.

    None where fewer than ``FEWEST`` persons would see a condition.
    """
    _check_target(target)
    group = people // len(model.success) if design == "between" else people
    if group < FEWEST:
        return None
    below, above = (_smallest_effect(model, design, group, target, end) for end in (0.0, 1.0))
    power = power_of(model, design, group)
    return PowerOfPeople(people=people, per_condition=group, power=power, below=below, above=above)


def _smallest_effect(model: People, design: Design, group: int, target: float, end: float) -> float | None:
    """The share nearest to the control's, towards ``end``, that is detected with the power ``target``."""
    control = model.success[0]

    def power_at(share: float) -> float:
        return power_of(replace(model, success=(control, *[share] * (len(model.success) - 1))), design, group)

    near, far = control, end + (control - end) * _EDGE
    if power_at(far) < target:
        return None
    while abs(far - near) > _EXACT:
        middle = (near + far) / 2
        near, far = (near, middle) if power_at(middle) >= target else (middle, far)
    return far


def people_needed(model: People, design: Design, target: float = 0.8) -> PeopleNeeded | None:
    """The fewest persons with which each comparison with the control has the power ``target``.

    None where more than a million would be needed, as where a condition has the success of the control.
    """
    _check_target(target)
    low, high = FEWEST, FEWEST
    while power_of(model, design, high) < target:
        low, high = high, 2 * high
        if high > _MOST:
            return None
    group = low + bisect_left(range(low, high), target, key=lambda persons: power_of(model, design, persons))
    groups = len(model.success) if design == "between" else 1
    return PeopleNeeded(people=group * groups, per_condition=group)


def power_of(model: People, design: Design, group: int) -> float:
    """The least power of the comparisons with the control, with ``group`` persons under each condition."""
    from scipy import stats

    (control, *treated), level, found = model.success, ALPHA / (len(model.success) - 1), []
    for share in treated:
        if design == "within":
            error, freedom = sqrt(_difference_variance(model, share)) / sqrt(group), group - 1.0
        else:
            both = ((control, model.person_sd), (share, model.treated_sd))
            parts = [_mean_variance(model, mean, deviation) / group for mean, deviation in both]
            error = sqrt(sum(parts))
            freedom = sum(parts) ** 2 / sum(part**2 / (group - 1) for part in parts)
        effect, edge = (share - control) / error, stats.t.ppf(1 - level / 2, freedom)
        tails = stats.nct.sf(edge, freedom, effect), stats.nct.cdf(-edge, freedom, effect)
        found.append(float(np.nan_to_num(tails).sum()))  # scipy has no number for a tail far below 1e-15
    return min(found)


def _check_target(target: float) -> None:
    if not 0 < target < 1:
        raise BadValue("target", target, "a power between 0 and 1")


def _difference_variance(model: People, share: float) -> float:
    """The variance over persons of the difference between the shares that they open, box luck included."""
    u, w = _normal(model.person_sd)
    v, x = _normal(model.effect_sd)
    control = _chance(_intercept(model.success[0], model.person_sd) + u)
    treated = _chance(_intercept(share, model.treated_sd) + u[:, None] + v)
    weights = w[:, None] * x
    difference = treated - control[:, None]
    mean = float((weights * difference).sum())
    between = float((weights * (difference - mean) ** 2).sum())
    luck = float((weights * treated * (1 - treated)).sum()) + float((w * control * (1 - control)).sum())
    return between + luck / model.boxes


def _mean_variance(model: People, share: float, deviation: float) -> float:
    """The variance over persons of the share that they open under one condition, box luck included."""
    u, w = _normal(deviation)
    chances = _chance(_intercept(share, deviation) + u)
    between = float((w * (chances - share) ** 2).sum())
    return between + float((w * chances * (1 - chances)).sum()) / model.boxes_in_all


@lru_cache(maxsize=1000)
def _intercept(share: float, deviation: float) -> float:
    """The logit whose mean over persons is a share."""
    from scipy.optimize import brentq

    u, w = _normal(deviation)
    return float(brentq(lambda a: float((w * _chance(a + u)).sum()) - share, -200.0, 200.0))


def _chance(logit: np.ndarray) -> np.ndarray:
    """The probability of a logit, also of a large one."""
    return 0.5 * (1 + np.tanh(logit / 2))


@lru_cache(maxsize=100)
def _normal(deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights that integrate over a normal distribution."""
    points, weights = np.polynomial.hermite_e.hermegauss(_POINTS)
    return deviation * points, weights / weights.sum()


def spread_by(model: People, factor: float) -> People:
    """The same model with both standard deviations multiplied by a factor: what the assumption decides."""
    return replace(model, person_sd=model.person_sd * factor, effect_sd=model.effect_sd * factor)
