"""Loop detectors, the paper's and others, with their error rates."""

from lockprobe.statistics.loops.detectors.catalogue import DETECTORS, Detector
from lockprobe.statistics.loops.detectors.comparison import Row, as_table, comparison, microseconds
from lockprobe.statistics.loops.detectors.verdicts import flags, score, share_flagged, threshold

__all__ = [
    "DETECTORS",
    "Detector",
    "Row",
    "as_table",
    "comparison",
    "flags",
    "microseconds",
    "score",
    "share_flagged",
    "threshold",
]
