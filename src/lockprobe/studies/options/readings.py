"""Readings of a false report as a factor of a study: which are played, and which conditions models are spared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.drop import Drop
from lockprobe.interventions.flip import DEFAULT, FlipKind
from lockprobe.studies.options import paper
from lockprobe.trial.condition import Condition

ALL: tuple[FlipKind, ...] = ("re-observed", "integrated", "memoryless", "latched")
"""The readings of a false report that the paper leaves open, the default first."""

_WORDS: dict[str, tuple[FlipKind, ...]] = {
    "fresh": ("re-observed",),
    "kept": ("integrated",),
    "transient": ("memoryless",),
    "sticky": ("latched",),
    "all": ALL,
    **{word: (word,) for word in ALL},
}


def readings_of(words: Sequence[str]) -> tuple[FlipKind, ...]:
    """The readings that are named, each once.

    >>> readings_of(["fresh", "kept"]), len(readings_of(["all"]))
    (('re-observed', 'integrated'), 4)

    Raises:
        BadValue: If one does not exist, comes twice, or none is named.
    """
    for word in words:
        check_choice("readings", word, _WORDS)
    found = [kind for word in words for kind in _WORDS[word]]
    if not found or len({*found}) < len(found):
        raise BadValue("readings", ",".join(words), "at least one, and every one once")
    return tuple(found)


def flips_of_readings(
    p: Sequence[float], kinds: Sequence[FlipKind], modalities: Sequence[str] | None = None
) -> tuple[Condition, ...]:
    """Every flip rate under every reading; the truth, which they share, comes once. Arguments as those of ``flips``."""
    rates = [rate for rate in p if rate > 0]
    others = [one for kind in kinds[1:] for one in flips(rates, kind, modalities)]
    return (*flips(p, kinds[0], modalities), *others)


def rates_of_models(extent: paper.Extent) -> Sequence[float]:
    """The flip rates that models play beside strategies: all, but in the short study."""
    return paper.SHORT_OF_MODELS if extent == paper.SHORT else extent.p


def conditions_for_strategies(extent: paper.Extent) -> Iterator[Condition]:
    """What strategies play besides the flip rates, since it costs nothing: false reports that stay.

    In the short study they also get no feedback at all: is a false report worse than none?
    """
    if extent in (paper.SHORT, paper.FULL):
        yield from flips_of_readings(extent.p, [DEFAULT, "integrated"])[len(extent.p) :]
    if extent == paper.SHORT:
        yield Condition(interventions=(Drop(p=1.0),), name="no-feedback")
