"""Dose axes: what conditions differ in, as their specs tell it, and every series of doses among them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import isnan

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import Spec
from lockprobe.trial.doses import can_be_fitted, dose_of, without_doses
from lockprobe.trial.record import STATES

AGENT = "agent"
"""The kind of an axis that is an option of agents, such as their temperature."""

_FEWEST = 3
"""Fewest doses, 0 included, that make a series."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """The one option in which conditions differ.

    Attributes:
        kind: Name of the intervention, for example ``tremble``; :data:`AGENT` for an option of agents.
        dose: The option that is its dose.
        options: Its other options, equal in all conditions, as in a spec: ``others=kept``; empty without any.
        rest: The other interventions, equal in all conditions, as specs joined by plus signs; empty if there are none.
    """

    kind: str
    dose: str
    options: str = ""
    rest: str = ""

    @property
    def name(self) -> str:
        """The name of the dose.

        >>> Axis(kind="tremble", dose="p").name, FLIPS.name
        ('tremble p', 'flip rate')
        """
        if self.kind == AGENT:
            return self.dose
        return "flip rate" if (self.kind, self.dose) == ("flip", "p") else f"{self.kind} {self.dose}"

    @property
    def of_flips(self) -> bool:
        """Whether its levels are rates of flips alone, of one reading of a false report."""
        return (self.kind, self.dose, self.rest) == ("flip", "p", "")


FLIPS = Axis(kind="flip", dose="p")
"""The axis of the paper (Sec. 3.2)."""


def axis_key(name: str, options: str = "", rest: str = "", number: int = 1) -> str:
    """What the column ``axis`` says of a dose: its name, what is equal at all levels, and which of several it is."""
    said = f"{name} ({options})" if options else name
    return f"{said}{f', with {rest}' if rest else ''}{f' ({number})' if number > 1 else ''}"


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesArm:
    """A condition as the specs of its interventions.

    Attributes:
        doses: For each intervention the names of its dose options; at 0 of the first one it does nothing.
    """

    label: str
    specs: tuple[Spec, ...]
    doses: tuple[tuple[str, ...], ...]
    modality: str = STATES

    @property
    def acting(self) -> tuple[int, ...]:
        """The places of interventions with an effect. At dose 0 there is none."""
        return tuple(i for i in range(len(self.specs)) if self.dose(i) != 0)

    @property
    def dosed(self) -> tuple[tuple[int, str], ...]:
        """Every dose of an intervention with an effect, as its place and the name of its option."""
        return tuple((i, dose) for i in self.acting for dose in self.doses[i] if not isnan(self.dose(i, dose)))

    def without(self, *places: int) -> tuple[str, ...]:
        """The specs of interventions with an effect, except at these places."""
        return tuple(str(self.specs[i]) for i in self.acting if i not in places)

    def dose(self, place: int, option: str = "") -> float:
        """A dose of the intervention at a place, its first one without a name; NaN without a dose.

        A second dose that its spec leaves out is 0.
        """
        first = next(iter(self.doses[place]), "")
        return dose_of(self.specs[place], option or first, first)

    def says(self, place: int, option: str) -> bool:
        """Whether the spec at a place says an option."""
        return option in self.specs[place].options

    def family(self, *differ: tuple[int, str]) -> tuple[object, ...]:
        """A key that is equal for conditions that differ only in these options, each with its place."""
        acts = []
        for place, option in differ:
            away = [name for at, name in differ if at == place]
            acts.append((self.specs[place].full_name, option, str(without_doses(self.specs[place], away))))
        return *acts, tuple(sorted(self.without(*(at for at, _ in differ)))), self.modality


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """Conditions that differ only in one dose, or agents that differ only in one option.

    Attributes:
        doses: Condition, or agent -> its dose, ascending; 0 for the condition without the intervention.
        agent: For a series of agents, what tables call them: their spec or their common name without the option, or all
            their names; else empty.
    """

    axis: Axis
    doses: Mapping[str, float]
    modality: str
    agent: str = ""


def series_of(arms: Sequence[SeriesArm]) -> tuple[Series, ...]:
    """Every series of at least three doses, in the order of the conditions; of equal doses the first counts."""
    dosed = ((arm, place, option) for arm in arms for place, option in arm.dosed)
    found = []
    for members in grouped(dosed, lambda one: one[0].family(one[1:])).values():
        labels: dict[float, str] = {}
        for arm, at, name in members:
            labels.setdefault(arm.dose(at, name), arm.label)
        first, place, option = members[0]
        rest, spec = first.without(place), first.specs[place]
        if option == first.doses[place][0]:
            zero = (one for one in arms if sorted(one.without()) == sorted(rest) and one.modality == first.modality)
            if alone := next(zero, None):
                labels.setdefault(0.0, alone.label)
        options = str(without_doses(spec, [option])).partition("?")[2]
        axis = Axis(kind=spec.full_name, dose=option, options=options, rest=" + ".join(rest))
        doses = {label: dose for dose, label in sorted(labels.items())}
        if len(doses) >= _FEWEST:
            found.append(Series(axis=axis, doses=doses, modality=first.modality))
    return tuple(found)


def series_of_agents(agents: Mapping[str, str]) -> tuple[Series, ...]:
    """Every series of at least three agents, by name with their specs, that differ only in one number."""
    families: dict[tuple[str, str], dict[str, float]] = {}
    for agent, text in agents.items():
        spec = Spec.parse(text)
        for option, value in spec.options.items():
            with suppress(ValueError):  # a word has no place on an axis, nor a number to which no curve can be fitted
                if can_be_fitted(number := float(value)):
                    families.setdefault((str(spec.without([option])), option), {})[agent] = number
    return tuple(
        Series(axis=Axis(kind=AGENT, dose=option), doses=doses, modality=STATES, agent=_called(doses, option))
        for (_, option), own in families.items()
        if len(doses := dict(sorted(own.items(), key=lambda both: both[1]))) >= _FEWEST
    )


def _called(agents: Iterable[str], option: str) -> str:
    """What agents are called together: by their names without the option, of more than three the first and the last."""
    names = [*dict.fromkeys(str(Spec.parse(agent).without([option])) for agent in agents)]
    return ", ".join(names) if len(names) <= _FEWEST else f"{names[0]} to {names[-1]}"
