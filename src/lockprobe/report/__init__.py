"""A study directory as numbers, tables, figures and one page that a scientist reads in a minute."""

from lockprobe.report.page import write_report
from lockprobe.report.results import results

__all__ = ["results", "write_report"]
