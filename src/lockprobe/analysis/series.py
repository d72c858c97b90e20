"""Which conditions of a study differ in one dose alone, and which are crossed, as their specs tell it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from lockprobe.analysis.axis import AGENT, Axis
from lockprobe.record import STATES
from lockprobe.spec import Spec, spec_name

__all__ = ["Crossing", "Series", "SeriesArm", "control_of", "crossings", "series_of", "series_of_agents"]

_FEWEST = 3
"""Doses, 0 among them, that make a series; two are a difference."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesArm:
    """A condition as its specs tell it.

    Attributes:
        label: Its name.
        specs: The specs of what acts, in order.
        doses: For each the option that is its dose; empty text where it has none.
        modality: How the box is shown.
    """

    label: str
    specs: tuple[str, ...]
    doses: tuple[str, ...]
    modality: str = STATES

    @property
    def acting(self) -> tuple[int, ...]:
        """The places of what acts; what has dose 0 does not, unless its other options change reports."""
        return tuple(i for i in range(len(self.specs)) if self._dose(i) != 0 or "outcome-only" in self.specs[i])

    def without(self, *places: int) -> tuple[str, ...]:
        """The specs of what acts but for those at some places."""
        return tuple(self.specs[i] for i in self.acting if i not in places)

    def dose(self, place: int) -> float:
        """The dose of what acts at a place; not a number where it has none."""
        found = self._dose(place)
        return float("nan") if found is None else found

    def _dose(self, place: int) -> float | None:
        dose, options = self.doses[place], Spec.parse(self.specs[place], "intervention").options
        return float(options[dose]) if dose and dose in options else None

    def family(self, place: int) -> tuple[str, str, tuple[tuple[str, str], ...], tuple[str, ...], str]:
        """What conditions have in common that differ in the dose at a place alone."""
        spec = Spec.parse(self.specs[place], "intervention")
        others = tuple(sorted(spec.without([self.doses[place]]).options.items()))
        return spec.full_name, self.doses[place], others, self.without(place), self.modality


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """Conditions that differ in one dose alone, or agents that differ in one option alone.

    Attributes:
        axis: What they differ in.
        doses: Condition -> its dose, ascending; 0 for the condition in which it is missing. Of agents: spec -> value.
        modality: How the box is shown in all of them.
        agent: Of agents: their spec without the option; else empty.
    """

    axis: Axis
    doses: Mapping[str, float]
    modality: str
    agent: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """Four conditions that cross two interventions.

    Attributes:
        neither: The condition without both.
        first: That with the first.
        second: That with the second.
        both: That with both.
    """

    neither: str
    first: str
    second: str
    both: str


def control_of(arms: Sequence[SeriesArm], modality: str = STATES) -> SeriesArm | None:
    """What the conditions of a modality are compared with: the truth, or the first where there is none."""
    shown = [arm for arm in arms if arm.modality == modality]
    return next((arm for arm in shown if not arm.acting), shown[0] if shown else None)


def series_of(arms: Sequence[SeriesArm]) -> tuple[Series, ...]:
    """Every series of at least three doses, in the order in which the conditions stand."""
    families: dict[tuple[object, ...], list[tuple[SeriesArm, int]]] = {}
    for arm in arms:
        for place in arm.acting:
            if arm.doses[place]:
                families.setdefault(arm.family(place), []).append((arm, place))
    found = []
    for members in families.values():
        first, place = members[0]
        doses = {arm.label: arm.dose(at) for arm, at in members}
        zero = [one for one in arms if one.without() == first.without(place) and one.modality == first.modality]
        if 0.0 not in doses.values():
            doses |= {one.label: 0.0 for one in zero[:1]}
        if len(doses) >= _FEWEST:
            name, rest = spec_name(first.specs[place]), " + ".join(first.without(place))
            axis = Axis(kind=name, dose=first.doses[place], rest=rest)
            ascending = dict(sorted(doses.items(), key=lambda both: both[1]))
            found.append(Series(axis=axis, doses=ascending, modality=first.modality))
    return tuple(found)


def series_of_agents(agents: Sequence[str]) -> tuple[Series, ...]:
    """Every series of at least three agents that differ in one number alone, such as their temperature."""
    families: dict[tuple[str, str], dict[str, float]] = {}
    for agent in agents:
        spec = Spec.parse(agent)
        for option, value in spec.options.items():
            if (number := _number(value)) is not None:
                families.setdefault((str(spec.without([option])), option), {})[agent] = number
    return tuple(
        Series(
            axis=Axis(kind=AGENT, dose=option),
            doses=dict(sorted(doses.items(), key=lambda both: both[1])),
            modality=STATES,
            agent=agent,
        )
        for (agent, option), doses in families.items()
        if len(doses) >= _FEWEST
    )


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def crossings(arms: Sequence[SeriesArm]) -> tuple[Crossing, ...]:
    """Every two interventions that were played alone, together, and not at all, beside the same others."""
    known: dict[tuple[str, tuple[str, ...]], str] = {}
    for arm in arms:
        known.setdefault((arm.modality, arm.without()), arm.label)
    found = []
    for arm in arms:
        for i, j in combinations(arm.acting, 2):
            names = [known.get((arm.modality, arm.without(*away))) for away in ((i, j), (j,), (i,))]
            if None not in names:
                neither, first, second = (str(name) for name in names)
                found.append(Crossing(neither=neither, first=first, second=second, both=arm.label))
    return tuple(found)
