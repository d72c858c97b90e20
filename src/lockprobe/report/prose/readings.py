"""What a false report is, in words: what is inverted, and what becomes of the false positions of other joints."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.flip import OutcomeFlip

_KNOWN: Mapping[tuple[str, str], str] = {
    ("outcome", "fresh"): "false reports",
    ("outcome", "kept"): "false reports that stay",
    ("position", "fresh"): "false positions",
    ("position", "kept"): "false positions that stay",
    ("position", "noisy"): "noise on all positions",
}

_POSITION, _OUTCOME = "the reported position of the attempted joint is inverted", "the reported outcome is inverted"

_CORRECTED = "a false position is corrected when another joint is attempted"
_STAY = "a false position stays until its joint is attempted again"

BOTH_FIT = "The paper does not say which of these false reports it has; its numbers fit agents under each."
"""Of several readings (``docs/readings.md``)."""


def false_reports(options: str) -> str:
    """False reports with these options of ``flip``, as the subject of a sentence.

    >>> false_reports(""), false_reports("others=kept"), false_reports("keep=0.5")
    ('false reports', 'false reports that stay', 'false reports (keep=0.5)')
    """
    said = Spec.parse(f"flip?{options}").options if options else {}
    known = _KNOWN.get((said.get("inverts", "outcome"), said.get("others", "fresh")))
    return known if known and said.keys() <= {"inverts", "others"} else f"false reports ({options})"


def reading_name(options: str) -> str:
    """A reading by what is inverted and what becomes of it, for tables and legends.

    >>> reading_name(""), reading_name("others=kept"), reading_name("keep=0.5")
    ('outcome inverted, then corrected', 'outcome inverted, stays', 'keep=0.5')
    """
    said = Spec.parse(f"flip?{options}").options if options else {}
    if said.keys() - {"inverts", "others"}:
        return options
    if said.get("others") == "noisy":
        return "every position inverted independently"
    stay = "stays" if said.get("others") == "kept" else "then corrected"
    return f"{said.get('inverts', 'outcome')} inverted, {stay}"


def inverted(flip: OutcomeFlip, *, positions: bool) -> str:
    """What is inverted with the probability that the flip rate is, and how long reports keep to it.

    Args:
        flip: What a false report is.
        positions: Whether reports tell positions.
    """
    if not positions:
        return _OUTCOME
    if flip.others == "noisy":
        return "a reported position is inverted, for every joint in every report"
    if flip.inverts == "position":
        return f"{_POSITION} {'until its next attempt' if flip.keep == 1 else 'in one report'}"
    return f"{_OUTCOME}; {_STAY if flip.keep == 1 else _CORRECTED}"
