"""Whether anything that a participant is told or shown can be false, so that it is admitted at the end."""

from __future__ import annotations

from lockprobe.foundation.spec import Spec
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses

__all__ = ["can_be_false"]

_NEVER_FALSE = frozenset({"drop", "reword", "nudge", "remark", "distract"})
"""What leaves something out, says the same in other words, or says something beside the report."""


def can_be_false(condition: Condition) -> bool:
    """Whether something can be false, late, or come of another joint than the chosen one.

    Interventions count unless they are known never to do that, so those of other packages do; a dose of 0 does nothing.

    >>> from lockprobe.interventions.conditions import read_condition
    >>> [can_be_false(read_condition(spec)) for spec in ("flip?p=0.4 + nudge", "flip?p=0 + nudge", "rgb?p=0.4")]
    [True, False, True]
    """
    if float(modality_doses(condition.modality)[1].get("p", "0")):
        return True
    return any(_acts(spec, doses) for spec, doses in condition.acting)


def _acts(spec: str, doses: tuple[str, ...]) -> bool:
    """Whether an intervention can make something false; ``doses`` are its dose options."""
    found = Spec.parse(spec, "intervention")
    return found.full_name not in _NEVER_FALSE and not (doses and float(found.options.get(doses[0], "0")) == 0)
