"""Which conditions follow other trials, by their specs: what they are told depends on what an agent did there."""

from __future__ import annotations

from dataclasses import replace

from lockprobe.foundation.spec import Spec
from lockprobe.trial.condition import Condition

__all__ = ["alone", "follows", "looping_rate", "source_named"]

_SOURCE = {"flip": "like", "yoked": "claims"}
"""Intervention -> the option that names the source."""


def follows(condition: Condition) -> bool:
    """Whether the trials of a condition depend on other trials."""
    return any(source_named(spec) is not None or looping_rate(spec) is not None for spec in condition.specs)


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


def looping_rate(spec: str) -> float | None:
    """The flip rate of the source, if an intervention is yoked to a trial with false reports in loops; else None."""
    found = Spec.parse(spec, "intervention")
    if found.full_name != "yoked" or found.options.get("how") != "looping":
        return None
    return float(found.options.get("p", "0"))
