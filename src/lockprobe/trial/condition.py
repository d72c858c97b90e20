"""A condition: a named, ordered composition of interventions, a modality, and what it changes of the plant."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, GetPydanticSchema, PlainSerializer

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import plugin_name_of
from lockprobe.foundation.spec import Spec, in_words, options_of, spec_name, split_specs
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import AS_WRITTEN, Text
from lockprobe.trial.doses import dose_of, flip_rate, modality_doses
from lockprobe.trial.protocols import Intervention, InterventionTraits
from lockprobe.trial.record import STATES

PLACES = {"told": "perceive", "asked": "brief", "remembered": "recall", "done": "act"}
"""Where an intervention can act -> the method by which it does, of the Protocols in :mod:`lockprobe.trial.protocols`.
"""

TRUTH = "truth"
"""The condition in which nothing acts."""

PLANT = "plant"
"""The part of a condition's spec that changes options of the plant: ``plant?pose_error=0.01``."""

_SHIPPED = "lockprobe.interventions."
"""Where the modules are whose classes have a ``name`` for specs; others are named by the entry point of their package.
"""

_LONGEST = 200
"""The most characters of the name of a condition."""

_DIGITS = 12
"""The digits of a dose of the plant, which is a difference of two numbers."""


def _listed(given: object) -> object:
    return (given,) if isinstance(given, str) else tuple(given) if isinstance(given, list) else given


_Labels = Annotated[tuple[Text, ...], BeforeValidator(_listed), Field(min_length=1, max_length=64)]


@dataclass(frozen=True, slots=True)
class Contrast:
    """Labels of conditions: what is asked is a mean under some, minus that under the others.

    In a study file one label may stand without a list. The mean is of success, or of what is misread: the share of
    statements about an attempt that contradict what happened.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    of: _Labels
    minus: _Labels
    measure: Literal["success", "misreading"] = "success"


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """An intervention as named in a study's settings, which import no code: its spec and its doses."""

    __pydantic_config__ = AS_WRITTEN

    spec: Text
    doses: tuple[Text, ...] = ()

    def __post_init__(self) -> None:
        if len(split_specs(self.spec)) != 1:
            raise BadValue("intervention", self.spec, "one")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantChange:
    """The options that a condition gives to the plant of its study.

    A dose of the plant is the distance of an option from its value in the study. So 0 is the study's own plant, as a
    dose of 0 of an intervention is none, and a dose is always larger the more is changed.

    Attributes:
        options: Option -> its value, of those that differ from the study's plant.
        own: Of those that are doses, the value in the study's plant.
    """

    __pydantic_config__ = AS_WRITTEN

    options: Mapping[Text, Annotated[str, Field(max_length=1000)]] = field(default_factory=dict)
    own: Mapping[Text, Annotated[float, Field(allow_inf_nan=False)]] = field(default_factory=dict)

    @property
    def spec(self) -> str:
        """All of it as the part of a spec; empty if nothing is changed."""
        return str(Spec(PLANT, options=self.options)) if self.options else ""

    def on(self, plant: str) -> str:
        """The spec of a study's plant with these options.

        >>> PlantChange(options={"pose_error": "0.01"}).on("twin?looks=varied")
        'twin?looks=varied&pose_error=0.01'
        """
        return str(Spec.parse(plant, PLANT).adding(self.options)) if self.options else plant

    @property
    def parts(self) -> tuple[tuple[Spec, tuple[str, ...]], ...]:
        """Each option alone as analyses read it: a dose as its distance from the study's value, with its name.

        >>> change = PlantChange(options={"friction": "0.3"}, own={"friction": 1.0})
        >>> [(dict(spec.options), doses) for spec, doses in change.parts]
        [({'friction below 1': '0.7'}, ('friction below 1',))]
        """
        found = list[tuple[Spec, tuple[str, ...]]]()
        for option, value in self.options.items():
            name, said, doses = option, value, tuple[str, ...]()
            if (own := self.own.get(option)) is not None:
                away = float(value) - own
                name = option if own == 0 < away else f"{option} {'above' if away > 0 else 'below'} {in_words(own)}"
                said, doses = in_words(round(abs(away), _DIGITS)), (name,)
            found.append((Spec(PLANT, options={name: said}), doses))
        return tuple(found)


def _recorded(interventions: tuple[Intervention | Recorded, ...]) -> list[dict[str, object]]:
    """Interventions as settings name them."""
    found = ((spec_of(one), [*InterventionTraits.of(one).doses]) for one in interventions)
    return [{"spec": spec} | ({"doses": doses} if doses else {}) for spec, doses in found]


@dataclass(frozen=True, kw_only=True)
class Condition:
    """The interventions that act in a trial, and the modality of the box; the empty condition is the truth.

    Attributes:
        name: The experimenter's name for it; empty for its spec.
        interventions: The interventions, in the order in which they act.
        modality: The spec of the modality: how the box is shown. It acts last.
        plant: What it changes of the study's plant.
        specs: The specs of the interventions, with every dose, and of the change of the plant. Conditions of equal
            specs, modality and name are equal.
    """

    __pydantic_config__ = AS_WRITTEN

    name: Annotated[str, Field(max_length=1000)] = ""
    interventions: Annotated[
        tuple[Intervention | Recorded, ...],
        GetPydanticSchema(lambda _, handler: handler(tuple[Recorded, ...])),  # settings name them
        PlainSerializer(_recorded),
    ] = field(default=(), compare=False)
    modality: Text = STATES
    plant: PlantChange = field(default_factory=PlantChange, compare=False)
    specs: Annotated[tuple[str, ...], Field(exclude=True)] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "specs", (*map(spec_of, self.interventions), *filter(None, [self.plant.spec])))
        label = self.label
        if not label.isprintable() or label != label.strip() or len(label) > _LONGEST:
            expected = f"a name (NAME=SPEC) of at most {_LONGEST} visible characters without blanks around it"
            raise BadValue("condition", printable(label), expected)

    @cached_property
    def spec(self) -> str:
        """The specs joined by plus signs, ``tremble?p=0.1 + nudge?after=2``; ``truth`` without interventions."""
        shown = () if self.modality == STATES else (self.modality,)
        return " + ".join((*self.specs, *shown)) or TRUTH

    @property
    def label(self) -> str:
        """Its name, or its spec."""
        return self.name or self.spec

    @property
    def is_recorded(self) -> bool:
        """Whether an intervention of it is only named, so that its code is not loaded."""
        return any(isinstance(one, Recorded) for one in self.interventions)

    @cached_property
    def acting(self) -> tuple[tuple[Spec, tuple[str, ...]], ...]:
        """Every intervention as its spec and the names of its dose options; at 0 of the first one it does nothing."""
        specs = (Spec.parse(spec, "intervention") for spec in self.specs)
        doses = (tuple(InterventionTraits.of(one).doses) for one in self.interventions)
        return tuple(zip(specs, doses, strict=False))  # the last spec may be the plant's

    @cached_property
    def parts(self) -> tuple[tuple[Spec, tuple[str, ...]], ...]:
        """The same of all that differs from the truth: interventions, doses of pictures, and options of the plant."""
        shown, worse = modality_doses(self.modality)
        pictured = [(Spec(spec_name(shown), options={option: value}), (option,)) for option, value in worse.items()]
        return *self.acting, *pictured, *self.plant.parts

    @cached_property
    def doses(self) -> Mapping[str, float]:
        """The doses that are not 0 of its interventions, of its modality and of its plant.

        For example ``{"flip.p": 0.4, "flip#2.p": 0.1, "rgb.blur": 8.0}``. At 0 of its first dose an intervention does
        not act.
        """
        found, seen = dict[str, float](), Counter[str]()
        try:
            for spec, options in (part for part in self.parts if part[1]):
                seen[first := f"{spec.full_name}.{options[0]}"] += 1
                name = spec.full_name + f"#{seen[first]}" * (seen[first] > 1)
                given = {option: dose_of(spec, option, options[0]) for option in options}
                if given[options[0]]:
                    found |= {f"{name}.{option}": dose for option, dose in given.items() if dose}
        except ValueError:
            raise BadValue("dose", self.spec, "a number; --sweep takes several") from None
        return found

    @property
    def p(self) -> float | None:
        """The flip rate, [0, 1], if one plain flip acts alone, 0 for the truth; else None."""
        return flip_rate(self.specs, self.modality, self.doses)

    @property
    def does_nothing(self) -> bool:
        """Whether it equals the truth: no intervention or doses of 0, and the study's own plant."""
        none = (doses and dose_of(spec, doses[0], doses[0]) == 0 for spec, doses in self.acting)
        return not self.plant.options and all(none)


def place_of(kind: type[Any]) -> str:
    """The place of the loop, of four, at which a class of interventions acts; any other class is refused."""
    found = [place for place, method in PLACES.items() if callable(getattr(kind, method, None))]
    if len(found) != 1:
        raise BadValue("intervention", kind.__name__, f"exactly one of {', '.join(PLACES.values())}")
    return found[0]


def spec_of(intervention: Intervention | Recorded) -> str:
    """The spec that makes an intervention: its doses, and all options not at their defaults, ``flip?p=0&others=kept``.

    Options that others imply (``implied``) are left out, so that equal interventions have equal specs.
    """
    if isinstance(intervention, Recorded):
        return intervention.spec
    kind, traits = type(intervention), InterventionTraits.of(intervention)
    own = traits.name if kind.__module__.startswith(_SHIPPED) else ""
    options = {
        option: in_words(value)
        for option, argument in options_of(kind).items()
        if argument.name not in traits.implied
        and ((value := getattr(intervention, argument.name)) != argument.default or argument.name in traits.doses)
    }
    return str(Spec.parse(own or plugin_name_of("intervention", kind), "intervention").adding(options))
