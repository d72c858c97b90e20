"""In which ways a study deceives people, so that it is admitted at the end."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, get_args

from lockprobe.foundation.spec import Spec
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses

Deception = Literal["false", "late", "another", "warned", "changed"]
"""What is told or shown is false, or late; another joint than the chosen one is attempted; reports that are true are
said to be perhaps false; or something is changed, nobody knows how, by an intervention of another package."""

_KINDS: dict[str, Deception | None] = {
    "flip": "false",
    "yoked": "false",
    "phantom": "false",
    "correction": "false",
    "delay": "late",
    "tremble": "another",
    "force": "another",
    "warn": "warned",
    **dict.fromkeys(("drop", "nudge", "remark", "distract")),
}
"""What an intervention does. None leaves something out, or says something beside."""


def deceptions(conditions: Iterable[Condition]) -> tuple[Deception, ...]:
    """The deceptions of a study, in a fixed order; none if everything is true.

    >>> from lockprobe.interventions.conditions import read_condition
    >>> deceptions(map(read_condition, ("flip?p=0.4 + nudge", "flip?p=0", "tremble?p=0.1")))
    ('false', 'another')
    """
    found = set[Deception]().union(*map(_in, conditions))
    return tuple(kind for kind in get_args(Deception) if kind in found)


def _in(condition: Condition) -> set[Deception]:
    """The deceptions of a condition. A dose of 0 does nothing, and a warning of false reports is true with some."""
    found, truth = set[Deception](), {"truth"}
    for text, doses in condition.acting:
        spec = Spec.parse(text, "intervention")
        corrects = (
            {spec.options.get("first"), spec.options.get("last", "truth")} if spec.full_name == "correction" else {}
        )
        kind = _KINDS.get(spec.full_name, "changed")
        if kind and corrects != truth and not (doses and float(spec.options.get(doses[0], "0")) == 0):
            found.add(kind)
    if float(modality_doses(condition.modality)[1].get("p", "0")):
        found.add("false")
    return found - {"warned"} if found & {"false", "late", "changed"} else found
