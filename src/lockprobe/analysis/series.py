"""Dose series and crossings among the conditions of a study, from their specs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from lockprobe.analysis.axis import AGENT, Axis
from lockprobe.doses import can_be_fitted
from lockprobe.record import STATES
from lockprobe.spec import Spec

__all__ = ["Crossing", "Series", "SeriesArm", "control_of", "crossings", "series_of", "series_of_agents"]

_FEWEST = 3
"""Fewest doses, 0 included, that make a series."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesArm:
    """A condition as its specs, for the search for dose series.

    Attributes:
        label: Its name.
        specs: The specs of its interventions, in order.
        doses: For each intervention the name of its dose option; empty without a dose.
        modality: How the box is shown.
    """

    label: str
    specs: tuple[Spec, ...]
    doses: tuple[str, ...]
    modality: str = STATES

    @property
    def acting(self) -> tuple[int, ...]:
        """The places of interventions with an effect. At dose 0 there is none, unless other options change reports."""
        return tuple(i for i in range(len(self.specs)) if self._dose(i) != 0 or "outcome-only" in str(self.specs[i]))

    def without(self, *places: int) -> tuple[str, ...]:
        """The specs of interventions with an effect, except at these places."""
        return tuple(str(self.specs[i]) for i in self.acting if i not in places)

    def dose(self, place: int) -> float:
        """The dose of the intervention at a place; NaN without a dose."""
        found = self._dose(place)
        return float("nan") if found is None else found

    def _dose(self, place: int) -> float | None:
        dose, options = self.doses[place], self.specs[place].options
        return float(options[dose]) if dose and dose in options else None

    def family(self, place: int) -> tuple[str, str, tuple[tuple[str, str], ...], tuple[str, ...], str]:
        """A key that is equal for conditions that differ only in the dose at a place."""
        spec = self.specs[place]
        others = tuple(sorted(spec.without([self.doses[place]]).options.items()))
        return spec.full_name, self.doses[place], others, self.without(place), self.modality


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """Conditions that differ only in one dose, or agents that differ only in one option.

    Attributes:
        axis: The dose or option.
        doses: Condition, or agent -> its dose, ascending; 0 for the condition without the intervention.
        modality: How the box is shown in all of them.
        agent: For a series of agents, what tables call them: their spec or their common name without the option, or all
            their names; else empty.
    """

    axis: Axis
    doses: Mapping[str, float]
    modality: str
    agent: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """The names of four conditions that cross two interventions."""

    neither: str
    first: str
    second: str
    both: str


def control_of(arms: Sequence[SeriesArm], modality: str = STATES) -> SeriesArm | None:
    """The control of a modality: the condition without interventions, or else the first."""
    shown = [arm for arm in arms if arm.modality == modality]
    return next((arm for arm in shown if not arm.acting), shown[0] if shown else None)


def series_of(arms: Sequence[SeriesArm]) -> tuple[Series, ...]:
    """Every series of at least three doses, in the order of the conditions."""
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
            name, rest = first.specs[place].full_name, " + ".join(first.without(place))
            options = str(first.specs[place].without([first.doses[place]])).partition("?")[2]
            axis = Axis(kind=name, dose=first.doses[place], options=options, rest=rest)
            ascending = dict(sorted(doses.items(), key=lambda both: both[1]))
            found.append(Series(axis=axis, doses=ascending, modality=first.modality))
    return tuple(found)


def series_of_agents(agents: Mapping[str, str]) -> tuple[Series, ...]:
    """Every series of at least three agents that differ only in one number, such as their temperature.

    Args:
        agents: What tables call an agent -> its spec.
    """
    families: dict[tuple[str, str], dict[str, float]] = {}
    for agent, text in agents.items():
        spec = Spec.parse(text)
        for option, value in spec.options.items():
            if (number := _number(value)) is not None:
                families.setdefault((str(spec.without([option])), option), {})[agent] = number
    return tuple(
        Series(
            axis=Axis(kind=AGENT, dose=option),
            doses=dict(sorted(doses.items(), key=lambda both: both[1])),
            modality=STATES,
            agent=_together(list(doses), option),
        )
        for (_, option), doses in families.items()
        if len(doses) >= _FEWEST
    )


def _together(agents: Sequence[str], option: str) -> str:
    """What several agents that differ in one option are called: what they are called without it, or all of them."""
    without = list(dict.fromkeys(str(Spec.parse(agent).without([option])) for agent in agents))
    return ", ".join(without)


def _number(text: str) -> float | None:
    """The number that an option is; None for a word, and for a number to which no curve can be fitted."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if can_be_fitted(number) else None


def crossings(arms: Sequence[SeriesArm]) -> tuple[Crossing, ...]:
    """Every 2 x 2 crossing: two interventions played alone, together and not at all, all else equal."""
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
