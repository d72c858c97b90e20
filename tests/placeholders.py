"""Reports with placeholders for figures, and a rough null of blind agents, for tests that look at other things."""

from contextlib import contextmanager

import pytest

from lockprobe.report import report_files
from lockprobe.statistics.loops import habit_baseline

__all__ = ["PLACEHOLDERS", "undrawn"]

PLACEHOLDERS = {"png": b"\x89PNG\r\n\x1a\n", "svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>'}

_DRAWN = report_files.drawn_figure
"""What draws a figure."""


@contextmanager
def undrawn(but=lambda name: False):
    """Reports within it hold placeholders for all figures but some, by name."""

    def instead(found, figure):
        if but(figure.name):
            return _DRAWN(found, figure)
        return PLACEHOLDERS if figure.applies(found) else None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_files, "drawn_figure", instead)
        patch.setattr(habit_baseline, "SIMULATED", 2_000)
        yield
