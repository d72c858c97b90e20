"""Action loops: their definition, their onset, and covers of a trial by them (paper, Sec. 3.3)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from lockprobe.statistics.loops.covering import (
        LoopCover,
        LoopMeasures,
        any_loop,
        cover,
        measure,
        onset,
        onset_batch,
    )

__all__ = ["LoopCover", "LoopMeasures", "Solver", "any_loop", "cover", "measure", "onset", "onset_batch"]

Solver = Literal["dp", "ilp"]
"""Both are exact. ``dp``: our own dynamic programme. ``ilp``: the paper's linear programme."""


def __getattr__(name: str) -> object:
    """Names are imported when they are first used, so that ``lockprobe loops --help`` does without NumPy."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.covering"), name)
