"""Reports with placeholders for figures, and few judged trials, for tests of other things."""

from contextlib import contextmanager

import pytest

from lockprobe.report import page
from lockprobe.report.questions import all_sections
from lockprobe.statistics import rationality

PLACEHOLDER = b'<svg xmlns="http://www.w3.org/2000/svg"/>'


@contextmanager
def undrawn():
    """Reports within it hold placeholders for all figures."""
    all_sections()  # their captions say how many trials are judged, so they are imported before that changes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "drawn_figure", lambda found, one: PLACEHOLDER if one.applies(found) else b"")
        patch.setattr(rationality, "JUDGED", 8)
        yield
