"""The design of a study, from its conditions alone: controls, dose axes, factors, what is crossed, and families.

Every contrast belongs to one family. The doses of an axis against its control are one: the flip rates of a modality,
and every dose with three levels or more of another intervention or another kind of flips. All other conditions of a
modality against its control are one, and so are the controls of the other modalities against that of the first; the
interactions of all that is crossed are one. So what is said of one family does not depend on the conditions of
another. Of another intervention a single dose is a condition like any other: with an axis of its own, ten conditions
would be ten families.

A dose has an order and a zero, a *factor* has levels, such as what becomes of a false report. Every level is compared
with the first one, all else equal; in each modality the contrasts of one factor are a family.

The interaction of crossed doses is a difference of differences: how much more the highest dose of one changes success
at the highest than at the lowest dose of the other.

The arms of the study of controls (``why``) are known by what acts in them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.spec import Spec, split_specs
from lockprobe.trial.condition import Contrast
from lockprobe.trial.doses import dose_of, without_doses
from lockprobe.trial.record import STATES

READING_FACTORS = ("flip others", "flip inverts")
"""Factors that are readings of a false report."""

CONDITIONS, CONTROLS, LEVELS = "conditions against the control", "modalities against the first", "levels of "
"""Families of comparisons beside those of axes: conditions, the controls of all modalities; and how the names of those
of factors begin."""

_FEWEST = 3
"""Fewest doses, 0 included, that make a series."""


_NUMBER = re.compile(r"([-+]?[\d.]+(e[-+]?\d+)?)?")
"""A level that is a number, or is not said."""

Dose = tuple[int, str]
"""The place of an intervention, and the name of a dose or an option of it."""


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
    def dosed(self) -> tuple[Dose, ...]:
        """Every dose of an intervention with an effect."""
        return tuple((i, dose) for i in self.acting for dose in self.doses[i] if not math.isnan(self.dose(i, dose)))

    def without(self, *places: int) -> tuple[str, ...]:
        """The specs of interventions with an effect, except at these places."""
        return tuple(str(self.specs[i]) for i in self.acting if i not in places)

    def dose(self, place: int, option: str = "") -> float:
        """A dose of the intervention at a place, its first one without a name; NaN without a dose.

        A second dose that its spec leaves out is 0.
        """
        first = next(iter(self.doses[place]), "")
        return dose_of(self.specs[place], option or first, first)

    def family(self, *differ: Dose) -> tuple[object, ...]:
        """A key that is equal for conditions that differ only in these options."""
        acts = []
        for place, option in differ:
            away = [name for at, name in differ if at == place]
            acts.append((self.specs[place].full_name, option, str(without_doses(self.specs[place], away))))
        return *acts, tuple(sorted(self.without(*(at for at, _ in differ)))), self.modality


ARMS: Mapping[str, str] = {one["name"]: one["spec"] for one in read_preset("why")["condition"]}
"""Arm -> its condition, with the flip rate and what a false report is to be filled in."""

CROSSED = ("truth-truth", "lie-truth", "truth-lie", "lie-lie")
"""The four arms of one form, by their first and last statement."""

PLANNED = ("truth", "lie", *CROSSED)
"""The arms without which there is no answer."""

_READING = ("inverts", "keep", "others")
"""The options of a flip that say what a false report is."""


def arms_of(conditions: Sequence[SeriesArm]) -> tuple[float, dict[str, str]] | None:
    """The flip rate of a study of controls and its conditions by arm, recognised by their specs, of one modality.

    None unless all arms of :data:`PLANNED` at one flip rate are among them.
    """
    found = {_acting(one.specs): one.label for one in conditions}
    for one in conditions:
        if len(one.specs) != 1 or (spec := one.specs[0]).full_name != "flip" or spec.options.keys() - {"p", *_READING}:
            continue
        rate = float(spec.options.get("p", 0))
        reading = "".join(f"&{name}={spec.options[name]}" for name in _READING if name in spec.options)
        asked = {arm: text.format(p=f"{rate:g}", reading=reading) for arm, text in ARMS.items() if text != "truth"}
        acts = {"truth": _acting(())} | {arm: _acting(map(Spec.parse, split_specs(of))) for arm, of in asked.items()}
        there = {arm: found[acting] for arm in ARMS if (acting := acts[arm]) in found}
        if rate > 0 and there.keys() >= {*PLANNED}:
            return rate, there
    return None


def _acting(specs: Iterable[Spec]) -> tuple[object, ...]:
    """Specs in a form that does not depend on the order of options, without those of dose 0."""
    return tuple((one.full_name, tuple(sorted(one.options.items()))) for one in specs if one.options.get("p") != "0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """A dose in which conditions differ alone; equal to that of other modalities.

    Attributes:
        kind: Name of the intervention, for example ``tremble``.
        dose: The option that is its dose.
        options: Its other options, equal in all conditions, as in a spec: ``others=kept``; empty without any.
        rest: The other interventions, equal in all conditions, as specs joined by plus signs; empty if there are none.
        modality: How the box is shown in all of them.
        doses: Condition -> its dose, ascending; 0 for the condition without the intervention.
    """

    kind: str
    dose: str
    options: str = ""
    rest: str = ""
    modality: str = field(default=STATES, compare=False)
    doses: Mapping[str, float] = field(default_factory=dict, compare=False)

    @property
    def name(self) -> str:
        """The name of the dose.

        >>> Axis(kind="tremble", dose="p").name, FLIPS.name
        ('tremble p', 'flip rate')
        """
        return "flip rate" if (self.kind, self.dose) == ("flip", "p") else f"{self.kind} {self.dose}"

    @property
    def key(self) -> str:
        """What the column ``axis`` says of it."""
        return axis_key(self.name, self.options, self.rest)

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


def series_of(arms: Sequence[SeriesArm]) -> Iterator[Axis]:
    """Every dose of at least three levels, in the order of the conditions; of equal doses the first counts."""
    dosed = ((arm, place, option) for arm in arms for place, option in arm.dosed)
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
        if len(labels) >= _FEWEST:
            options = str(without_doses(spec, [option])).partition("?")[2]
            doses = {label: dose for dose, label in sorted(labels.items())}
            yield Axis(
                kind=spec.full_name, dose=option, options=options, rest=" + ".join(rest), modality=first.modality,
                doses=doses,
            )  # fmt: skip


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
    def interaction(self) -> Contrast | None:
        """Half of it, as a contrast; None if one of the four conditions is not played."""
        (low, *_, high), (least, *_, most) = self.doses
        alike, apart = ((low, least), (high, most)), ((low, most), (high, least))
        if not {*alike, *apart} <= self.conditions.keys():
            return None
        of, minus = (tuple(self.conditions[at] for at in corners) for corners in (alike, apart))
        return Contrast(of=of, minus=minus)


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
        said = all(any(pair[of][1] in arm.specs[pair[of][0]].options for arm, *pair in members) for of in (0, 1))
        if said and min(map(len, (grid := _grid(members, known)).doses)) > 1:
            yield grid


def _grid(members: Sequence[tuple[SeriesArm, Dose, Dose]], known: Mapping[tuple[str, ...], str]) -> Crossed:
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


class Family(NamedTuple):
    """Conditions that are compared, and judged together.

    Attributes:
        name: The dose, :data:`CONDITIONS`, :data:`CONTROLS`, or :data:`LEVELS` with the option.
        groups: First of each comes the condition that all others of it are compared with.
        modality: How the box is shown under the control; empty for options.
        axis: The dose whose levels they are; None for others.
    """

    name: str
    groups: tuple[tuple[str, ...], ...]
    modality: str = ""
    axis: Axis | None = None


def factors_of(
    arms: Sequence[SeriesArm], controls: Collection[str], dosed: Sequence[Collection[str]] = ()
) -> Iterator[Family]:
    """Every option that is no number, in which conditions differ alone, in the order of the conditions.

    First of each group comes the condition that does not say it, or else the first of the study.
    With ``controls`` others are compared already, and so are those that are ``dosed``, together on one axis.
    """
    levels: dict[tuple[str, str], dict[tuple[object, ...], dict[str, str]]] = {}
    options = {(spec.full_name, option) for arm in arms for spec in arm.specs for option in spec.options}
    for arm in arms:
        for place in arm.acting:
            spec = arm.specs[place]
            for kind, option in sorted(options):
                if kind == spec.full_name and option not in arm.doses[place]:
                    groups = levels.setdefault((f"{kind} {option}", arm.modality), {})
                    own = groups.setdefault(arm.family((place, option)), {})
                    own.setdefault(spec.options.get(option, ""), arm.label)
    for (name, _), groups in levels.items():
        kept = [own for own in groups.values() if len(own) > 1 and not all(map(_NUMBER.fullmatch, own))]
        first_without = [tuple(own[level] for level in sorted(own, key=bool)) for own in kept]
        new = [one for one in first_without if one[0] not in controls and not any({*one} <= {*of} for of in dosed)]
        if new:
            yield Family(LEVELS + name, tuple(new))


@dataclass(frozen=True, kw_only=True)
class Design:
    """What differs between the conditions of a study.

    Attributes:
        agents: What tables call the agents.
        axis: Labels of the conditions that differ in flip rate and modality alone, the truth among them.
        specs: Agent -> its spec, of those that are called otherwise.
    """

    agents: tuple[str, ...]
    arms: tuple[SeriesArm, ...]
    axis: frozenset[str]
    specs: Mapping[str, str] = field(default_factory=dict)

    def spec_of(self, agent: str) -> str:
        """The spec of an agent."""
        return self.specs.get(agent, agent)

    @cached_property
    def shown(self) -> Mapping[str, Sequence[SeriesArm]]:
        """How the box is shown, without doses, each way once -> its conditions."""
        return grouped(self.arms, lambda arm: arm.modality)

    @cached_property
    def controls(self) -> Mapping[str, str]:
        """Modality -> its control: the condition without interventions, or else the first."""
        return {name: next((arm for arm in own if not arm.acting), own[0]).label for name, own in self.shown.items()}

    def control(self, label: str) -> str:
        """The label of the control of a condition."""
        return next(self.controls[arm.modality] for arm in self.arms if arm.label == label)

    @cached_property
    def series(self) -> tuple[Axis, ...]:
        """Other doses than flip rates, of three levels or more."""
        doses = [one for one in series_of(self.arms) if not one.doses.keys() <= self.axis]
        # flips without options are of another reading beside the flip axis, which their name says
        return tuple(replace(one, options="others=fresh") if one == FLIPS else one for one in doses)

    @cached_property
    def crossed(self) -> Mapping[str, tuple[Crossed, ...]]:
        """Modality -> two interventions alone, together and not at all, then crossed doses."""
        return {modality: tuple(crossed_of(own)) for modality, own in self.shown.items()}

    @cached_property
    def against_controls(self) -> tuple[Family, ...]:
        """The conditions of each modality by the families of their contrasts with its control.

        Flip rates, every other dose of which the control is a level, all other conditions, and in the first modality
        the controls of the others.
        """
        found = list[Family]()
        for modality, control in self.controls.items():
            own, others = self.shown[modality], () if found else tuple(self.controls.values())[1:]
            rates = {arm.label: max(map(arm.dose, arm.acting), default=0.0) for arm in own if arm.label in self.axis}
            axes = [replace(FLIPS, modality=modality, doses=rates)] if rates else []
            axes += [one for one in self.series if one.modality == modality and control in one.doses]
            on_axes = {control}.union(*(one.doses for one in axes))
            rest = [arm.label for arm in own if arm.label not in on_axes]
            found += [
                Family(one.name, ((control, *(label for label in one.doses if label != control)),), modality, one)
                for one in axes
            ]
            found.append(Family(CONDITIONS, ((control, *rest),), modality))
            found.append(Family(CONTROLS, ((control, *others),), modality))
        return tuple(found)

    @cached_property
    def families(self) -> tuple[Family, ...]:
        """What is compared with what, beside the doses of axes.

        Levels on the axis of a dose are none, nor what the arms of a study of controls say first and last.
        """
        dosed: list[Collection[str]] = [one.doses for one in self.series]
        dosed += [arms[1].values() for shown in self.shown.values() if (arms := arms_of(shown))]
        against = [one for one in self.against_controls if one.axis is None]
        return (*against, *factors_of(self.arms, self.controls.values(), dosed))
