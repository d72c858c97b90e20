"""The arms of the study of controls, which a study plays and its analysis finds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from lockprobe.foundation.spec import Spec, split_specs
from lockprobe.statistics.conditions.axis import SeriesArm

ARMS: Mapping[str, str] = {
    "truth": "truth",
    "lie": "flip?p={p:g}{reading}",
    "truth-truth": "correction?p={p:g}&first=truth{reading}",
    "lie-truth": "correction?p={p:g}{reading}",
    "truth-lie": "correction?p={p:g}&first=truth&last=lie{reading}",
    "lie-lie": "correction?p={p:g}&last=lie{reading}",
    "remark": "distract?p={p:g}&luck=flip",
}
"""Arm -> its condition at the rate p: a report is inverted; reports of two statements, of which the second is called a
correction, cross what is said first and last; an irrelevant sentence follows a true report."""

CROSSED = ("truth-truth", "lie-truth", "truth-lie", "lie-lie")
"""The four arms of one form, by their first and last statement."""

PARTS: Mapping[str, str] = {
    "false outcome": "flip?p={p:g}&part=outcome",
    "false position": "flip?p={p:g}&part=position",
    "phantom": "phantom?p={p:g}",
    "hidden moves": "flip?p={p:g}&only=moved",
    "invented moves": "flip?p={p:g}&only=blocked",
}
"""Parts of a false report, which ``run why --parts`` plays too (``docs/readings.md``)."""

ON_REQUEST: Mapping[str, str] = {
    "withheld": "drop?p={p:g}&luck=flip",
    "nudge": "nudge",
    "lie in loops": "flip?p={p:g}&while=looping",
}
"""More arms, which are named as conditions: no report; a sentence that names an action loop; a report that is inverted
only where the agent is in an action loop."""

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
                there = {
                    arm: found[wanted]
                    for arm, text in {**ARMS, **PARTS, **ON_REQUEST}.items()
                    if (wanted := _wanted(text, rate, reading)) in found
                }
                if there.keys() >= set(PLANNED):
                    return rate, there
    return None


def _wanted(text: str, rate: float, reading: str) -> _Acting:
    """The interventions of an arm at a rate."""
    return _acting(map(Spec.parse, split_specs(text.format(p=rate, reading=reading))) if text != "truth" else ())


def _acting(specs: Iterable[Spec]) -> _Acting:
    """Specs in a form that does not depend on the order of options, without those of dose 0."""
    return tuple((one.full_name, tuple(sorted(one.options.items()))) for one in specs if one.options.get("p") != "0")
