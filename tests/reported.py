"""The results of a study that is written into a directory."""

from builders import write_study

from lockprobe.report.results import results


def found_in(directory, planned, trials=None):
    """The results of the study that is played as planned, or of these trials of it."""
    return results(write_study(directory / "study", planned, trials))
