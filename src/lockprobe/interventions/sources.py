"""Which conditions follow other trials, by their specs: what they are told depends on what an agent did there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from lockprobe.foundation.spec import Spec
from lockprobe.trial.condition import Condition

__all__ = ["alone", "follows", "looping_rate", "looping_source", "rates_from", "source_named", "sources_of"]

_SOURCE = {"flip": "like", "yoked": "claims"}
"""Intervention -> the option that names the source."""


def follows(condition: Condition) -> bool:
    """Whether the trials of a condition depend on other trials."""
    return _any_follows(condition.specs)


@lru_cache(maxsize=1024)
def _any_follows(specs: tuple[str, ...]) -> bool:
    return any(source_named(spec) is not None or looping_rate(spec) is not None for spec in specs)


def alone(condition: Condition) -> Condition:
    """The condition without what follows other trials, for a trial that is made up and not played."""
    acting = zip(condition.interventions, condition.specs, strict=False)  # the last spec may be the plant's
    kept = tuple(one for one, spec in acting if source_named(spec) is None and looping_rate(spec) is None)
    return replace(condition, interventions=kept, name=condition.label)


def source_named(spec: str) -> str | None:
    """The source that an intervention names, a condition of this study or of another; None if it names none.

    >>> source_named("yoked?claims=rgb"), source_named("flip?p=0.4")
    ('rgb', None)
    """
    found = Spec.parse(spec, "intervention")
    return found.options.get(_SOURCE.get(found.full_name, ""))


def rates_from(spec: str) -> str | None:
    """The source whose trials all together give an intervention its flip rates; None if it takes none so.

    >>> rates_from("flip?like=rgb"), rates_from("yoked?claims=rgb")
    ('rgb', None)
    """
    return source_named(spec) if Spec.parse(spec, "intervention").full_name == "flip" else None


def looping_rate(spec: str) -> float | None:
    """The flip rate of the source, if an intervention is yoked to a trial with false reports in loops; else None."""
    found = Spec.parse(spec, "intervention")
    if found.full_name != "yoked" or found.options.get("how") != "looping":
        return None
    return float(found.options.get("p", "0"))


def sources_of(condition: Condition, conditions: Sequence[Condition]) -> frozenset[str]:
    """The labels of those conditions of a study whose trials have to be played before those of a condition."""
    named = {source for spec in condition.specs if (source := source_named(spec)) is not None}
    looping = looping_source(condition, conditions) if follows(condition) else None
    return frozenset(one.label for one in conditions if one.label in named or one is looping)


def looping_source(condition: Condition, conditions: Sequence[Condition]) -> Condition | None:
    """The source condition: the same with ``flip?while=looping`` instead of the yoked intervention; None without."""
    wanted = [_instead(spec) for spec in condition.specs]
    for one in conditions:
        if one.modality == condition.modality and [_options(spec) for spec in one.specs] == wanted:
            return one
    return None


def _instead(spec: str) -> tuple[str, dict[str, str]]:
    rate = looping_rate(spec)
    return _options(spec) if rate is None else ("flip", {"p": f"{rate:g}", "while": "looping"})


def _options(spec: str) -> tuple[str, dict[str, str]]:
    found = Spec.parse(spec, "intervention")
    return found.full_name, dict(found.options)
