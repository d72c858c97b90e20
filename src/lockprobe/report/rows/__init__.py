"""What a study found, as rows: the content of ``results.json``, which tables, figures and pages read.

A number is an :class:`Estimate`, a line of a figure a :class:`Curve`. What is no number is a :class:`Finding` (a
sentence) or a :class:`Fact` (a property, as text). A quantity that could not be measured has no row; a fact says why.
"""

from lockprobe.report.rows.course import Cell, Course
from lockprobe.report.rows.design import Condition, Contrast, Design, DoseAxis, EveryLook, LeftOut, Player, Progress
from lockprobe.report.rows.results import MEASURES, NoSuchRow, Results
from lockprobe.report.rows.row import UNITS, Curve, Estimate, Fact, Finding, Row, clearness

__all__ = [
    "MEASURES",
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
    "Finding",
    "LeftOut",
    "NoSuchRow",
    "Player",
    "Progress",
    "Results",
    "Row",
    "clearness",
]
