"""From specs to interventions: ``flip?p=0.4``, and several with plus signs between, in the order in which they act.

What ships stands in :data:`SHIPPED`. A package of one's own adds to it by an entry point in the group
``lockprobe.interventions``, whose name is the spec's; ``python:module:Name?lag=1`` names a class directly, from code or
from the command line, never from a file.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any
from urllib.parse import urlencode

from lockprobe.errors import BadValue, UnknownName
from lockprobe.interventions.burst import Burst
from lockprobe.interventions.delay import Delay
from lockprobe.interventions.drop import Drop
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.force import Force
from lockprobe.interventions.forget import Forget
from lockprobe.interventions.history import History
from lockprobe.interventions.nudge import Nudge
from lockprobe.interventions.remark import Remark
from lockprobe.interventions.tremble import Tremble
from lockprobe.interventions.warn import Warn
from lockprobe.options import read_options, with_options
from lockprobe.plugins import Listed, find_plugin, listed_plugins, plugin_name_of, plugin_names
from lockprobe.seams import Intervention

__all__ = ["PLACES", "SHIPPED", "TRUTH", "condition", "kinds", "packaged", "place_of", "spec_of"]

PLACES = {"told": "perceive", "asked": "brief", "remembered": "recall", "done": "act"}
"""Where an intervention can act -> the method by which it does, of the Protocols in :mod:`lockprobe.seams`."""

TRUTH = "truth"
"""The condition in which nothing acts."""

SHIPPED: dict[str, type[Any]] = {
    kind.name: kind for kind in (OutcomeFlip, Drop, Delay, Burst, Warn, Nudge, Remark, History, Forget, Tremble, Force)
}
"""Name -> class."""


def packaged() -> list[Listed]:
    """The interventions of installed packages; with each that cannot be used stands why."""
    return listed_plugins("intervention", SHIPPED, _checked)


def kinds() -> dict[str, type[Any]]:
    """Every intervention that can be named: those that ship, and those of installed packages that can be used."""
    return SHIPPED | {row.name: row.found for row in packaged() if row.found is not None}


def condition(spec: str) -> tuple[Intervention, ...]:
    """The interventions of a condition, in the order in which they act.

    >>> [type(one).__name__ for one in condition("tremble?p=0.1 + nudge?after=2")]
    ['Tremble', 'Nudge']

    Args:
        spec: Specs with plus signs between; ``truth`` or nothing is the empty condition.

    Raises:
        UnknownName: If there is no such intervention, or it has no such option.
        BadValue: If an option has a value that it cannot have.
    """
    if spec.strip() in ("", TRUTH):
        return ()
    return tuple(_made(part.strip()) for part in spec.split("+"))


def spec_of(intervention: Intervention) -> str:
    """The spec from which :func:`condition` makes an intervention; options at their defaults are left out.

    >>> spec_of(Tremble(p=0.1)), spec_of(OutcomeFlip())
    ('tremble?p=0.1', 'flip')
    """
    kind = type(intervention)
    shipped = {named: name for name, named in SHIPPED.items()}
    name = shipped.get(kind) or plugin_name_of("intervention", kind)
    settings: tuple[Field[Any], ...] = fields(kind) if is_dataclass(kind) else ()
    options = {
        field.name: _word(getattr(intervention, field.name))
        for field in settings
        if getattr(intervention, field.name) != _default(field)
    }
    return f"{name}?{urlencode(options)}" if options else name


def place_of(kind: type[Any]) -> str:
    """At which of the four places a class of interventions acts.

    Raises:
        BadValue: If that is none of them, or more than one.
    """
    found = [place for place, method in PLACES.items() if callable(getattr(kind, method, None))]
    if len(found) != 1:
        raise BadValue("intervention", kind.__name__, f"exactly one of {', '.join(PLACES.values())}")
    return found[0]


def _made(spec: str) -> Intervention:
    name, options = read_options(spec, "intervention")
    if name in SHIPPED:
        shipped: Intervention = with_options(SHIPPED[name], name, options)
        return shipped
    if (plugin := find_plugin("intervention", name)) is None:
        raise UnknownName("intervention", name, [*SHIPPED, *plugin_names("intervention")])
    kind = _checked(name, plugin.load())
    with plugin.guarded():
        made: Intervention = with_options(kind, name, options)
    return made


def _checked(spec: str, kind: Any) -> type[Any]:
    """A class of interventions, as its seam wants it."""
    frozen = isinstance(kind, type) and is_dataclass(kind) and getattr(kind, "__dataclass_params__").frozen  # noqa: B009
    if not frozen:
        raise BadValue("intervention", spec, "a frozen dataclass")
    place_of(kind)
    found: type[Any] = kind
    return found


def _default(field: Field[Any]) -> object:
    return field.default if field.default_factory is MISSING else field.default_factory()


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
