"""The figures of a report, by file name: the paper's, and beside each its corrected companion."""

from __future__ import annotations

from lockprobe.analysis.summary import StudySummary

__all__ = ["CAPTIONS", "Pictures", "pictures"]

Pictures = dict[str, dict[str, bytes]]

CAPTIONS = {}


def pictures(summary: StudySummary) -> Pictures:
    """Every figure as PNG and SVG; none if no trial has ended."""
    if not any(condition.success.n for condition in summary.conditions):
        return {}

    return {}
