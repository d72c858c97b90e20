"""Action loops: what they are, where they begin, and how much of a trial they cover (paper, Sec. 3.3)."""

from lockprobe.analysis.loops.cover import LONGEST_ILP, LoopCover, Rule, Solver, cover
from lockprobe.analysis.loops.words import any_loop, any_loop_batch, onset_batch, parse_sequence

__all__ = [
    "LONGEST_ILP",
    "LoopCover",
    "Rule",
    "Solver",
    "any_loop",
    "any_loop_batch",
    "cover",
    "onset_batch",
    "parse_sequence",
]
