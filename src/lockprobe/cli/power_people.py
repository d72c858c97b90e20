"""``lockprobe power --people``: how many persons a design needs."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping, Sequence
from dataclasses import asdict

from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.simulation.power.people import FEWEST, Design, People, needed_by_spread

__all__ = ["power_people", "refuse_other_options"]

_DESIGNS: tuple[Design, ...] = ("within", "between")

_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed standard deviations are multiplied by, to show how much they decide."""


def refuse_other_options(people: bool, what: str | None, given: Sequence[str], harm: float) -> None:
    """Refuse what says something about trials of agents beside what says something about people.

    Raises:
        Conflict: If there is anything.
    """
    if not people:
        raise Conflict("--boxes, --person-sd and --effect-sd", "trials of agents", "they need --people")
    names = [*([what] if what else []), *(f"--{name.replace('_', '-')}" for name in given)]
    if names := [*names, *(["--harm"] if harm != 1.0 else [])]:
        raise Conflict("--people", ", ".join(names), "it takes --success, --boxes, --person-sd, --effect-sd, --target")


def power_people(
    success: Sequence[float] | None, of_people: Mapping[str, float | None], target: float, *, json: bool
) -> None:
    """Print how many persons each design needs, for the assumed standard deviations, for half of them, and for more.

    Args:
        success: The share of boxes opened under each condition, the control first.
        of_people: Fields of :class:`People`; None for the default.
        target: The power to reach.
        json: Whether to print JSON.

    Raises:
        BadValue: If a value makes no model.
    """
    if success is None:
        raise BadValue("--success", None, "the share of boxes opened under each condition, the control first: 0.4,0.6")
    model = People(success=tuple(success), **{name: value for name, value in of_people.items() if value is not None})  # type: ignore[arg-type] # named as its fields are
    found = {design: needed_by_spread(model, design, target, _FACTORS) for design in _DESIGNS}
    if json:
        rows = [
            {
                "design": design,
                "person_sd": model.person_sd * factor,
                "effect_sd": model.effect_sd * factor,
                "people": None if one is None else one.people,
                "per_condition": None if one is None else one.per_condition,
            }
            for design, needed in found.items()
            for factor, one in zip(_FACTORS, needed, strict=True)
        ]
        print(json_.dumps({"target": target, **asdict(model), "designs": rows}, indent=1))
        return
    spreads = (f"SD {model.person_sd * factor:g} and {model.effect_sd * factor:g}" for factor in _FACTORS)
    table = new_table("design", "boxes each", *spreads)
    for design, needed in found.items():
        cells = ("more than a million" if one is None else f"{one.people}" for one in needed)
        table.add_row(f"{design} persons", str(model.boxes_in_all), *cells)
    print_table(table)
    assumed = None in (of_people["person_sd"], of_people["effect_sd"])
    plain_console().print(_explained(target, by_eye=assumed))


def _explained(target: float, *, by_eye: bool) -> str:
    defaults = "; the defaults are chosen by eye, not measured" if by_eye else ""
    return (
        f"\nPersons in all for a power of {target:g}. SD: standard deviations between persons, in logits, of skill "
        f"(--person-sd) and of the effect of a condition (--effect-sd){defaults}. The columns beside the middle one "
        "have half of them, and half as much again: plan with the largest number of your row until a pilot has "
        f"measured them. At least {FEWEST} persons see each condition. Persons who leave or are screened out come on "
        "top.\n"
        "Assumption: a person's boxes are independent but for skill, and nobody learns from box to box. Tests: a "
        "paired t test on shares (within), Welch's t test on shares (between), Bonferroni's correction over "
        "conditions."
    )
