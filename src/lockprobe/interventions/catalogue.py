"""The interventions by spec: ``flip?p=0.4``; plus signs join several, in the order in which they act.

What ships is every class of this package with a ``name``. An installed package adds to it by an entry point in the
group ``lockprobe.interventions``, whose name is the spec's; ``python:module:Name?lag=1`` names a class directly, in
Python or on the command line.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import is_dataclass
from functools import cache
from typing import Any, TypeVar, cast

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import Listed, find_plugin, listed_plugins, plugin_names
from lockprobe.foundation.spec import Spec, split_specs, with_options
from lockprobe.trial.condition import TRUTH, place_of
from lockprobe.trial.protocols import Intervention, InterventionTraits

One = TypeVar("One")


def packaged() -> list[Listed]:
    """The interventions of installed packages, including unusable ones with the reason."""
    return listed_plugins("intervention", shipped(), _checked)


@cache
def shipped() -> dict[str, type[Any]]:
    """The interventions of this package, by their names in specs.

    A variant, which an option chooses, has the option behind its name: ``flip?like``.
    """
    package = __name__.rpartition(".")[0]
    found: dict[str, type[Any]] = {}
    for module in pkgutil.iter_modules(importlib.import_module(package).__path__, f"{package}."):
        for kind in vars(importlib.import_module(module.name)).values():
            own = isinstance(kind, type) and kind.__module__ == module.name
            if own and (traits := InterventionTraits.of(kind)).name:
                found[traits.name + f"?{traits.variant}" * bool(traits.variant)] = kind
    return dict(sorted(found.items()))


def shipped_as(spec: Spec) -> type[Any] | None:
    """The class of this package that a spec names, also by its option (``flip?like=rgb``); None if there is none."""
    name, found = spec.full_name, shipped()
    return next((kind for option in spec.options if (kind := found.get(f"{name}?{option}"))), found.get(name))


def interventions_of(spec: str) -> tuple[Intervention, ...]:
    """The interventions of a condition, in the order in which they act.

    Specs are joined by plus signs; ``truth`` or nothing is the empty condition.
    """
    if spec.strip() in ("", TRUTH):
        return ()
    return tuple(_made(Spec.parse(part, "intervention")) for part in split_specs(spec))


def with_words(interventions: Sequence[One], words: One) -> tuple[One, ...]:
    """Interventions with the report in words inserted: only those with ``after_words`` act after it."""
    after = [one for one in interventions if InterventionTraits.of(one).after_words]
    return (*(one for one in interventions if one not in after), words, *after)


def _made(spec: Spec) -> Intervention:
    name = spec.full_name
    if (kind := shipped_as(spec)) is not None:
        return cast(Intervention, with_options(kind, name, spec.options))
    if (plugin := find_plugin("intervention", str(spec))) is None:
        raise UnknownName("intervention", name, [*shipped(), *plugin_names("intervention")])
    kind = _checked(name, plugin.load())
    with plugin.guarded():
        return cast(Intervention, with_options(kind, name, spec.options))


def _checked(spec: str, kind: Any) -> type[Any]:
    """Check that a class of interventions follows the protocol of its place."""
    if not (isinstance(kind, type) and is_dataclass(kind) and getattr(kind, "__dataclass_params__").frozen):  # noqa: B009
        raise BadValue("intervention", spec, "a frozen dataclass")
    place_of(kind)
    return kind
