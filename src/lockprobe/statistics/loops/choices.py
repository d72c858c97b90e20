"""The options of a loop cover: its selection rule and its solver. Quick to import."""

from __future__ import annotations

from typing import Literal

__all__ = ["Rule", "Solver"]

Rule = Literal["free", "repeat", "whole"]
"""What a cover may be made of; each rule covers at most what the one before it does.

* ``free``: every chosen piece is a copy of some loop. What the paper's text says.
* ``repeat``: as ``free``, and every chosen loop is chosen at least twice.
* ``whole``: a loop is chosen with all its copies (two or more disjoint ones, from the left), or not at all.
"""

Solver = Literal["dp", "ilp"]
"""Both are exact, for every rule. ``dp``: our own; a dynamic programme for ``free``, a search for ``repeat`` and
``whole``. ``ilp``: the paper's linear programme."""
