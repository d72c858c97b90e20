"""Reports with placeholders for figures, and a rough null of blind agents, for tests that look at other things."""

from contextlib import contextmanager

import pytest

from lockprobe.analysis import habit_baseline
from lockprobe.report import figures

__all__ = ["DRAW", "PLACEHOLDERS", "undrawn"]

DRAW = {name: getattr(figures, name) for name in ("_draw", "_draw_condition")}
"""What draws figures of numbers."""

PLACEHOLDERS = {"png": b"\x89PNG\r\n\x1a\n", "svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>'}


@contextmanager
def undrawn(*more):
    """Nothing is drawn within it; ``more`` functions that draw are named."""
    with pytest.MonkeyPatch.context() as patch:
        for name in (*DRAW, *more):
            patch.setattr(figures, name, lambda *asked: PLACEHOLDERS)
        patch.setattr(habit_baseline, "SIMULATED", 2_000)
        yield
