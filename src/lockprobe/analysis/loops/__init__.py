"""Action loops: what they are, where they begin, and how much of a trial they cover (paper, Sec. 3.3)."""

from lockprobe.analysis.loops.covering import LONGEST_ILP, LoopCover, Rule, Solver, cover
from lockprobe.analysis.loops.measures import LoopMeasures, measure
from lockprobe.analysis.loops.search import LONGEST_SEARCH
from lockprobe.analysis.loops.symbols import Symbol, parse_sequence, symbols
from lockprobe.analysis.loops.words import any_loop, any_loop_batch, longest_loop, onset, onset_batch

__all__ = [
    "LONGEST_ILP",
    "LONGEST_SEARCH",
    "LoopCover",
    "LoopMeasures",
    "Rule",
    "Solver",
    "Symbol",
    "any_loop",
    "any_loop_batch",
    "cover",
    "longest_loop",
    "measure",
    "onset",
    "onset_batch",
    "parse_sequence",
    "symbols",
]
