"""A condition as ``study.json`` holds it: enough to read records by, whatever of it can be imported there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, split_specs
from lockprobe.interventions.catalogue import shipped_as
from lockprobe.trial.condition import Condition, Recorded
from lockprobe.trial.plant_change import PlantChange

Text = Annotated[str, Field(min_length=1, max_length=1000)]


class _Intervention(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    spec: Text
    doses: list[Text] = []


class _PlantChange(BaseModel):
    """Options of the plant, and what those that are doses are in the study's plant."""

    model_config = ConfigDict(strict=True, extra="forbid")
    options: Annotated[dict[Text, Annotated[str, Field(max_length=1000)]], Field(min_length=1)]
    own: dict[Text, Annotated[float, Field(allow_inf_nan=False)]] = {}


class ConditionSettings(BaseModel):
    """A condition on disk."""

    model_config = ConfigDict(strict=True, extra="forbid")
    name: Annotated[str, Field(max_length=1000)]
    interventions: list[_Intervention]
    modality: Text
    plant: _PlantChange | None = None

    def condition(self) -> Condition:
        """The condition, of which nothing is imported.

        Raises:
            BadValue: If a spec holds several interventions, or a dose is no number.
        """
        for act in self.interventions:
            if len(split_specs(act.spec)) != 1:
                raise BadValue("intervention", act.spec, "one")
            options = Spec.parse(act.spec, "intervention").options
            for dose in act.doses:
                _check_number(f"dose {dose} of {act.spec}", options.get(dose, ""))
        return Condition(
            interventions=tuple(Recorded(spec=act.spec, doses=_doses(act)) for act in self.interventions),
            modality=self.modality,
            name=self.name,
            plant=PlantChange() if self.plant is None else _plant(self.plant),
        )


def condition_settings(condition: Condition) -> dict[str, object]:
    """A condition as JSON holds it."""
    acting = [
        {"spec": spec, **({"doses": said} if (said := _said(spec, doses)) else {})} for spec, doses in condition.acting
    ]
    found = {"name": condition.name, "interventions": acting, "modality": condition.modality}
    change = condition.plant
    own = {"own": dict(change.own)} if change.own else {}
    return found | ({"plant": {"options": dict(change.options), **own}} if change.options else {})


def _said(spec: str, doses: Sequence[str]) -> list[str]:
    """The first dose of an intervention, and the others that its spec says as a number."""
    options = Spec.parse(spec, "intervention").options
    return [dose for dose in doses if dose == doses[0] or dose in options]


def _plant(change: _PlantChange) -> PlantChange:
    for option in change.own:
        _check_number(f"dose {option} of the plant", change.options.get(option, ""))
    return PlantChange(options=change.options, own=change.own)


def _doses(act: _Intervention) -> tuple[str, ...]:
    """All doses of an intervention of Lockprobe, said or left out; of other packages' those on record."""
    own = shipped_as(Spec.parse(act.spec, "intervention"))
    return tuple(act.doses) if own is None or not act.doses else tuple(own.doses)


def _check_number(what: str, text: str) -> None:
    try:
        float(text)
    except ValueError:
        raise BadValue(what, text, "a number among its options") from None
