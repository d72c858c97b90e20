"""Covers of a trial by action loops.

An *action loop* is a run of three or more consecutive actions that stands at least twice in one trial. The paper (Sec.
3.3) reports the share of trials that hold one, and covers a trial by disjoint loops of greatest total length, by a
binary integer linear programme. It does not say whether the two copies may overlap (here by default not: ``A A A A``
holds no loop), which changes how many trials loop, nor what a cover may choose (:data:`Rule`), which does not.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, get_args

from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops.alphabet import letters
from lockprobe.statistics.loops.choices import Rule, Solver
from lockprobe.statistics.loops.exact_cover import Words, copies, free_pieces, in_order
from lockprobe.statistics.loops.exact_search import LONGEST_SEARCH, repeat_pieces, whole_pieces
from lockprobe.statistics.loops.integer_programme import programme_pieces
from lockprobe.statistics.loops.words import Interval, any_loop, least_distance

__all__ = ["LONGEST_ILP", "LoopCover", "cover"]

LONGEST_ILP = 120


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCover:
    """One cover of a trial by action loops.

    Args:
        n: Actions in the trial.
        any_loop: Whether the trial holds a loop at all, whatever the cover's rule.
        covered: Actions inside the cover, 0 to n.
        words: The distinct loops of the cover, in order of first appearance.
        intervals: Where they stand, as (start from 0, length), sorted and disjoint.
    """

    n: int
    any_loop: bool
    covered: int
    words: Words
    intervals: tuple[Interval, ...]

    @property
    def share(self) -> float:
        """Covered share of the trial, 0 to 1 (0 for an empty trial)."""
        return self.covered / self.n if self.n else 0.0

    @property
    def redundant(self) -> int:
        """Covered actions that are not in the first copy of their loop, 0 to ``covered``."""
        return self.covered - sum(map(len, self.words))


def cover(
    sequence: Sequence[Hashable] | NDArray[Any],
    *,
    rule: Rule = "free",
    solver: Solver = "dp",
    overlap: bool = False,
    min_length: int = 3,
) -> LoopCover:
    """Cover as much of a trial as possible by disjoint copies of its action loops (maximum coverage).

    Of several greatest covers ``free`` takes the one of fewest pieces, longest first. A piece that is itself a
    repetition is then written as its copies, ``ABCABC`` as ``ABC ABC``: loops on the same actions. Above 5000
    actions its pieces are fewest among those of ``min_length`` to ``2 * min_length - 1`` actions, which cover
    as much in linear time. ``repeat`` and ``whole`` take that cover where it obeys them, else any greatest one.
    ``ilp`` takes one of fewest pieces, then of long ones (``whole``: of few, then short loops).

    20 actions take 0.02 ms (``free``) or 0.1 to 0.3 ms; 1000 take 0.1 to 0.2 ms once compiled, 1 ms without numba;
    10**6 take 0.1 s or 0.5 s. What is compiled is loaded once longer trials of a process make it worth while.

    Args:
        sequence: The actions in order.
        rule: What a cover may be made of. ``repeat`` and ``whole`` take at most ``LONGEST_SEARCH`` actions.
        solver: Our exact solver, or the paper's integer linear programme, of at most ``LONGEST_ILP`` actions.
        overlap: Whether the two copies that make a loop may share actions. Chosen pieces never do.
        min_length: Fewest actions in a loop (at least 1; 3 in the paper).

    >>> found = cover("ABCABCABC")
    >>> found.words, found.intervals, found.share
    ((('A', 'B', 'C'),), ((0, 3), (3, 3), (6, 3)), 1.0)
    """
    if rule not in get_args(Rule):
        raise BadValue("cover rule", rule, "free, repeat or whole")
    if solver not in get_args(Solver):
        raise BadValue("solver", solver, "dp or ilp")
    least_distance(min_length, overlap=overlap)
    if solver == "dp" and rule == "free":
        pieces, words = free_pieces(sequence, min_length, overlap=overlap)
        looping = bool(pieces)
    else:
        pieces = _bounded(sequence, rule, solver, min_length, overlap=overlap)
        words = in_order(sequence, pieces)
        looping = any_loop(sequence, min_length=min_length, overlap=overlap)
    covered = sum([length for _, length in pieces])
    return LoopCover(n=len(sequence), any_loop=looping, covered=covered, words=words, intervals=tuple(pieces))


def _bounded(
    sequence: Sequence[Hashable] | NDArray[Any], rule: Rule, solver: Solver, min_length: int, *, overlap: bool
) -> list[Interval]:
    """The pieces, by the solvers that limit the length of a trial."""
    n = len(sequence)
    if solver == "dp" and n > LONGEST_SEARCH:
        expected = f"at most {LONGEST_SEARCH}; try the solver ilp (up to {LONGEST_ILP}), or the rule free (no limit)"
        raise BadValue(f"actions under the rule {rule}", n, expected)
    if n > LONGEST_ILP:
        raise BadValue("actions for the solver ilp", n, f"at most {LONGEST_ILP}; dp with the rule free has no limit")
    text = letters(sequence)
    if solver == "dp":
        return (repeat_pieces if rule == "repeat" else whole_pieces)(text, min_length)
    pieces = programme_pieces(text, rule, min_length, overlap=overlap)
    return pieces if rule == "whole" else [part for piece in pieces for part in copies(text, piece, min_length)]
