"""A study directory as numbers, tables, figures and one page that a scientist reads in a minute."""

from lockprobe.report.page import content_of, write_report
from lockprobe.report.schema import Results, results

__all__ = ["Results", "content_of", "results", "write_report"]
