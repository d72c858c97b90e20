"""The sections of a report, in the order of the page."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from lockprobe.report.section import Section

_OWN = (
    "first_screen", "trials", "seen", "people", "stopping", "contrasts", "why", "success", "boxes",
    "loops", "agents_compared", "speed", "decisions", "robot", "conditions", "study_design",
    "claims", "forks",
)  # fmt: skip
"""Modules of this package, each with its ``SECTIONS``: the answer and one trial; whether it is more than chance, and
whether it acts through loops; agents beside each other; all numbers; the study itself."""


@cache
def all_sections() -> tuple[Section, ...]:
    """Every section of a report."""
    return tuple(one for name in _OWN for one in import_module(f"{__name__}.{name}").SECTIONS)
