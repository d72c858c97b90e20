"""Action loops: their definition, their onset, and covers of a trial by them (paper, Sec. 3.3)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from lockprobe.statistics.loops.covering import LONGEST_ILP, LoopCover, cover
    from lockprobe.statistics.loops.measures import LoopMeasures, measure
    from lockprobe.statistics.loops.sequence_line import parse_sequence
    from lockprobe.statistics.loops.words import any_loop, any_loop_batch, onset, onset_batch

__all__ = [
    "LONGEST_ILP",
    "LoopCover",
    "LoopMeasures",
    "Solver",
    "any_loop",
    "any_loop_batch",
    "cover",
    "measure",
    "onset",
    "onset_batch",
    "parse_sequence",
]

Solver = Literal["dp", "ilp"]
"""Both are exact. ``dp``: our own dynamic programme. ``ilp``: the paper's linear programme."""

_HOMES = {
    "covering": ("LONGEST_ILP", "LoopCover", "cover"),
    "measures": ("LoopMeasures", "measure"),
    "sequence_line": ("parse_sequence",),
    "words": ("any_loop", "any_loop_batch", "onset", "onset_batch"),
}


def __getattr__(name: str) -> object:
    """Names are imported when they are first used, so that ``lockprobe loops --help`` does without NumPy."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
