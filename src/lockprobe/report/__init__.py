"""A study directory as numbers, tables, figures and one page that a scientist reads in a minute."""

from lockprobe.report.write import write_report

__all__ = ["write_report"]
