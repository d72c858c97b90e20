"""Reports with placeholders for figures, and few judged trials, for tests of other things."""

from contextlib import contextmanager

import pytest

from lockprobe.report import write
from lockprobe.report.questions import all_sections
from lockprobe.statistics import rationality

PLACEHOLDERS = {"svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>', "png": b"\x89PNG\r\n\x1a\n"}

_DRAWN = write.drawn_figure
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
        forms = PLACEHOLDERS if figure.slide else {"svg": PLACEHOLDERS["svg"]}
        return forms if figure.applies(found) else {}

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(write, "drawn_figure", instead)
        patch.setattr(rationality, "JUDGED", judged)
        yield
