"""The paper's figures, each with a companion from which conclusions may be drawn.

Drawing only: every number comes from the rows of :class:`lockprobe.report.rows.Results`. A figure is a function
that takes results and returns a figure of Matplotlib, or None where there is nothing to draw; ``render`` makes a file
of it.
"""

from lockprobe.report.figures.settings import own_settings  # isort: skip - first of all, since it imports Matplotlib

from lockprobe.report.figures.compose import pages_as_pdf, render, sheet

__all__ = ["own_settings", "pages_as_pdf", "render", "sheet"]
