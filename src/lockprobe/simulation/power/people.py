"""Studies of people of a stated effect, within and between persons, put through the test of the report.

The model: a person opens a box under condition c with the logit a_c + u + v_c. u is the person's skill, normal with
standard deviation ``person_sd``. v_c is how much the person differs from others in the effect of c, normal with
standard deviation ``effect_sd``, and 0 under the control. a_c is such that the mean over persons is the stated share.
Boxes of a person are independent given u and v. Learning from box to box is not in it.

The test is that of the report: every condition against the control, clustered by person and by luck, corrected for the
conditions. A t test on persons' shares, with which such studies are often planned, detects 3 to 10 points more often.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import hypot
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.simulator import Needed, Simulation, detections, needed
from lockprobe.statistics.differences import each_difference
from lockprobe.statistics.distributions import root
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA

Design = Literal["within", "between"]

PERSON_SD = 1.0
"""The default standard deviation of skill, in logits, chosen by eye: at a mean of one half, the middle two thirds of
persons open 29 to 71 % of their boxes."""

EFFECT_SD = 0.5
"""The default standard deviation of effects between persons, in logits, chosen by eye: half of that of skill."""

FEWEST = 10
"""The fewest persons under a condition."""

PERSONS = (10, 20, 40, 80, 160)
"""Persons for each condition at which power is measured."""

_POINTS = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    """The persons of a study and what each plays.

    Attributes:
        success: Share of boxes opened under each condition, the control first.
        design: Whether each person plays every condition, or one.
        boxes: Boxes that a person plays under each condition (within). Between, a person plays as many boxes in all,
            under one condition.
        person_sd: Standard deviation of skill between persons, in logits.
        effect_sd: Standard deviation of effects between persons, in logits.
    """

    success: tuple[float, ...]
    design: Design = "within"
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
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", "people", self.design, f"{self.person_sd:g}", f"{self.effect_sd:g}"

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> Iterator[int]:
        """The places of the conditions that the report tells from the control, in a study of so many persons in all.

        Between persons a remainder of them is left out.
        """
        groups = self._played(trials, luck)
        yield from (place for place, one in each_difference(groups, tests) if one.p_value < ALPHA)

    def _played(self, persons: int, luck: np.random.Generator) -> list[Outcomes]:
        """The trials of one study under each condition."""
        within, conditions = self.design == "within", len(self.success)
        n, boxes = (persons, self.boxes) if within else (persons // conditions, self.boxes_in_all)
        skill, found = luck.normal(0, self.person_sd, (1 if within else conditions, n)), list[Outcomes]()
        for place, share in enumerate(self.success):
            logit = _intercept(share, hypot(self.person_sd, self.effect_sd * bool(place))) + skill[place * (not within)]
            if place:
                logit = logit + luck.normal(0, self.effect_sd, n)
            solved = luck.random((n, boxes)) < _chance(logit)[:, None]
            # a person meets no luck twice, and under every condition somebody meets it
            number = np.roll(np.arange(n * boxes).reshape(n, boxes), place, axis=0).reshape(-1)
            nothing = np.zeros(n * boxes, dtype=np.int64)
            found.append(
                Outcomes(
                    dose=np.full(n * boxes, float(place)),
                    repetition=nothing + 1,
                    trial=number + 1,
                    length=nothing,
                    solved=solved.reshape(-1),
                    onset=nothing,
                    player=np.repeat(np.arange(n) + n * place * (not within), boxes).astype(np.str_),
                )
            )
        return found


def people_power(models: list[People], how: Simulation, *, seed: int = 1) -> list[Needed]:
    """The power of each study at numbers of persons in all, and the persons that it needs.

    It is that of its hardest comparison: the condition that is least often told from the control at the largest number.

    Raises:
        BadValue: If fewer than :data:`FEWEST` persons would see a condition.
    """
    sizes = sorted(set(how.trials))
    for model in models:
        least = FEWEST * (1 if model.design == "within" else len(model.success))
        if sizes[0] < least:
            raise BadValue("persons", sizes[0], f"{least} or more in all, {FEWEST} under each condition")
    powers = []
    for model, found in zip(models, detections(models, how, seed), strict=True):
        largest = found[sizes[-1]]
        powers.append(needed(found, min(range(1, len(model.success)), key=largest.__getitem__), how))
    return powers


@lru_cache(maxsize=1000)
def _intercept(share: float, deviation: float) -> float:
    """The logit whose mean over persons, normal with this standard deviation, is a share."""
    points, weights = np.polynomial.hermite_e.hermegauss(_POINTS)
    return root(lambda a: float(weights @ _chance(a + deviation * points) / weights.sum()) - share, -200.0, 200.0)


def _chance(logit: NDArray[np.float64]) -> NDArray[np.float64]:
    """The probability of a logit, also of a large one."""
    return np.asarray(0.5 * (1 + np.tanh(logit / 2)))
