"""The results of a study that is written into a directory, and its tables."""

from builders import write_study

from lockprobe.report.format import texts
from lockprobe.report.page import cells_of
from lockprobe.report.questions import all_sections
from lockprobe.report.results import results


def found_in(directory, planned, trials=None):
    """The results of the study that is played as planned, or of these trials of it."""
    return results(write_study(directory / "study", planned, trials))


def tables_of(found):
    """The tables of all sections by name, as text."""
    return {table.name: texts(cells_of(table, found)) for one in all_sections() for table in one.tables}
