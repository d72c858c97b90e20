"""A study directory as numbers, tables, figures and one page that a scientist reads in a minute."""

from lockprobe.report.page import results, write_report
from lockprobe.report.schema import Results

__all__ = ["Results", "results", "write_report"]
