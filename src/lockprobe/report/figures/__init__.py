"""The paper's figures, each with a companion from which conclusions may be drawn.

Drawing only: every number comes from the rows of :class:`lockprobe.report.rows.Results`. A figure is a function
that takes results and returns a figure of Matplotlib, or None where there is nothing to draw; ``render`` makes a file
of it.
"""

from lockprobe.report.figures.drawing import as_pdf, render

__all__ = ["as_pdf", "render"]
