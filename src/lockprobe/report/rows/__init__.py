"""What a study found, as rows: the content of ``results.json``, which tables, figures and pages read.

A number is an :class:`Estimate`, a line of a figure a :class:`Curve`. What is no number is a
:class:`Fact`: a property, or a sentence. A quantity that could not be measured has no row.
"""

from lockprobe.report.rows.design import Condition, Contrast, Design, DoseAxis, EveryLook, LeftOut, Player, Progress
from lockprobe.report.rows.results import MEASURES, RECONSTRUCTED, Cell, Course, NoSuchRow, Results
from lockprobe.report.rows.row import (
    BOUNDS,
    PERMUTED,
    UNITS,
    Curve,
    Estimate,
    Fact,
    Row,
    clearness,
    detected_said,
    measured,
    measured_row,
    share_rows,
)

__all__ = [
    "BOUNDS",
    "MEASURES",
    "PERMUTED",
    "RECONSTRUCTED",
    "UNITS",
    "Cell",
    "Condition",
    "Contrast",
    "Course",
    "Curve",
    "Design",
    "DoseAxis",
    "Estimate",
    "EveryLook",
    "Fact",
    "LeftOut",
    "NoSuchRow",
    "Player",
    "Progress",
    "Results",
    "Row",
    "clearness",
    "detected_said",
    "measured",
    "measured_row",
    "share_rows",
]
