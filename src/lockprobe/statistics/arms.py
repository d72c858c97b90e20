"""Conditions as the specs of their interventions, and the arms of the study of controls (``why``) among them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.spec import Spec, split_specs
from lockprobe.trial.doses import dose_of, without_doses
from lockprobe.trial.record import STATES

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

_Acting = tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
"""Interventions, each as its name and its options by name."""

_READING = ("inverts", "keep", "others")
"""The options of a flip that say what a false report is."""


def arms_of(conditions: Sequence[SeriesArm]) -> tuple[float, dict[str, str]] | None:
    """The flip rate of a study of controls and its conditions by arm, recognised by their specs, of one modality.

    None unless all arms of :data:`PLANNED` at one flip rate are among them.
    """
    found = {_acting(one.specs): one.label for one in conditions}
    for one in conditions:
        if len(one.specs) == 1 and (spec := one.specs[0]).full_name == "flip":
            rate = float(spec.options.get("p", 0))
            reading = "".join(f"&{name}={spec.options[name]}" for name in _READING if name in spec.options)
            if rate > 0 and spec.options.keys() <= {"p", *_READING}:
                wanted = {arm: _wanted(text, rate, reading) for arm, text in ARMS.items()}
                there = {arm: found[acts] for arm, acts in wanted.items() if acts in found}
                if there.keys() >= set(PLANNED):
                    return rate, there
    return None


def _wanted(text: str, rate: float, reading: str) -> _Acting:
    """The interventions of an arm at a rate."""
    return _acting(map(Spec.parse, split_specs(text.format(p=f"{rate:g}", reading=reading))) if text != "truth" else ())


def _acting(specs: Iterable[Spec]) -> _Acting:
    """Specs in a form that does not depend on the order of options, without those of dose 0."""
    return tuple((one.full_name, tuple(sorted(one.options.items()))) for one in specs if one.options.get("p") != "0")
