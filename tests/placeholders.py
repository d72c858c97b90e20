"""Reports with placeholders for figures, and few judged trials, for tests of other things."""

from contextlib import contextmanager

import pytest

from lockprobe.report import page
from lockprobe.report.questions import all_sections
from lockprobe.statistics import rationality

PLACEHOLDER = b'<svg xmlns="http://www.w3.org/2000/svg"/>'

_DRAWN = page.drawn_figure
"""What draws a figure."""


@contextmanager
def undrawn(but=lambda name: False, judged=8):
    """Reports within it hold placeholders for all figures but some, by name.

    Args:
        but: Whether the figure of a name is drawn.
        judged: Of how many trials of a condition it is judged whether their actions were optimal.
    """
    all_sections()  # their captions say how many trials are judged, so they are imported before that changes

    def instead(found, figure):
        if but(figure.name):
            return _DRAWN(found, figure)
        return PLACEHOLDER if figure.applies(found) else b""

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "drawn_figure", instead)
        patch.setattr(rationality, "JUDGED", judged)
        yield
