"""The options of the plant that a condition changes, and the doses among them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field

from lockprobe.foundation.spec import Spec, in_words
from lockprobe.foundation.validation import AS_WRITTEN, Text, check_dose

PLANT = "plant"
"""The part of a condition's spec that changes options of the plant: ``plant?pose_error=0.01``."""

_DIGITS = 12
"""The digits of a dose, which is a difference of two numbers."""


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

    def __post_init__(self) -> None:
        for option in self.own:
            check_dose(f"dose {option} of the plant", self.options.get(option, ""))

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
        return tuple(self._part(option, value) for option, value in self.options.items())

    def _part(self, option: str, value: str) -> tuple[Spec, tuple[str, ...]]:
        if (own := self.own.get(option)) is None:
            return Spec(PLANT, options={option: value}), ()
        away = float(value) - own
        name = option if own == 0 < away else f"{option} {'above' if away > 0 else 'below'} {in_words(own)}"
        return Spec(PLANT, options={name: in_words(round(abs(away), _DIGITS))}), (name,)

    @property
    def doses(self) -> dict[str, float]:
        """Its doses by name, all above 0.

        >>> PlantChange(options={"pose_error": "0.01"}, own={"pose_error": 0.0}).doses
        {'plant.pose_error': 0.01}
        """
        return {f"{PLANT}.{name}": float(spec.options[name]) for spec, doses in self.parts for name in doses}
