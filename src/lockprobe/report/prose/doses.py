"""What sentences call a dose: its cause, its zero, and a condition at one of its values."""

from __future__ import annotations

from lockprobe.report.prose.readings import false_reports
from lockprobe.statistics.conditions.axis import AGENT, FLIPS, Axis
from lockprobe.trial.plant_change import PLANT

_PICTURED = ("rgb", "rgbd")
"""Modalities, whose pictures can be false, blurred, noisy or covered."""


def cause(axis: Axis) -> str:
    """What may change an agent's success.

    >>> cause(FLIPS), cause(Axis(kind="tremble", dose="p")), cause(Axis(kind=AGENT, dose="t"))
    ('false reports', 'higher doses of tremble', 'higher values of t')
    """
    if axis.kind == AGENT:
        return f"higher values of {axis.dose}"
    if axis.name == FLIPS.name:
        return false_reports(axis.options)
    said = f"higher doses of {_short(axis)}"
    return f"{said} ({axis.options})" if axis.options else said


def at_dose(p: float, axis: Axis = FLIPS) -> str:
    """Under which condition, within a sentence.

    >>> at_dose(0), at_dose(0.4), at_dose(0, Axis(kind="tremble", dose="p", rest="nudge"))
    ('when told the truth', 'at a flip rate of 0.4', 'under nudge alone')
    >>> at_dose(0, Axis(kind="plant", dose="pose_error"))
    "with the study's own plant"
    """
    if p:
        return f"at a {axis.name} of {p:g}"
    if axis.kind == PLANT:
        return "with the study's own plant"
    if axis.rest:
        return f"under {axis.rest} alone"
    if axis.kind == AGENT:
        return f"at a {axis.dose} of 0"
    return "when told the truth" if axis.name == FLIPS.name else f"without {_short(axis)}"


def _short(axis: Axis) -> str:
    """An intervention goes by its name; pictures and plants have several doses."""
    return axis.name if axis.kind in (*_PICTURED, PLANT) else axis.kind
