"""Conditions that exact propagation supports: chances depend on step and outcome alone."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

from lockprobe.errors import BadValue
from lockprobe.interventions.catalogue import interventions_of, place_of, spec_of
from lockprobe.interventions.condition import default_modality
from lockprobe.interventions.drop import Drop
from lockprobe.interventions.flip import FlipKind, OutcomeFlip
from lockprobe.interventions.force import Force
from lockprobe.interventions.reword import Reword
from lockprobe.interventions.tremble import Tremble
from lockprobe.interventions.words import TextChannel
from lockprobe.protocols import Intervention
from lockprobe.studies.modality import shown

__all__ = ["Acting", "acting_of", "tells_states_only"]

_KNOWN = "flip (but while=looping), drop, tremble, force, reword and what is asked; sample others (lockprobe.run_trial)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Acting:
    """A condition as chances.

    Attributes:
        flip: The outcome flip.
        silent: Probability that nothing is told of an attempt, [0, 1].
        states_only: Whether positions are told and no outcomes.
        hands: What changes which joint is attempted, in order.
    """

    flip: OutcomeFlip
    silent: float = 0.0
    states_only: bool = False
    hands: tuple[Tremble | Force, ...] = ()

    def phase(self, step: int) -> Hashable:
        """What is alike at all steps at which the same can happen."""
        return self.flip.falls_on(step), *(isinstance(hand, Force) and hand.at == step for hand in self.hands)

    def attempted(self, chances: Sequence[float], step: int) -> Sequence[float]:
        """The probability that each joint is attempted, from the probability that it is chosen."""
        for hand in self.hands:
            if isinstance(hand, Tremble):
                others = len(chances) - 1
                chances = [(1 - hand.p) * chance + hand.p * (1 - chance) / others for chance in chances]
            elif hand.at == step:
                chances = [1 / len(chances)] * len(chances)
        return chances

    def reports(self, step: int, *, moved: bool) -> Iterator[tuple[bool | None, float]]:
        """Whether a report of what happened is inverted, None where there is none, and how probably."""
        may = self.flip.falls_on(step) and self.flip.only in ("any", "moved" if moved else "blocked")
        lie = self.flip.p if may else 0.0
        told = 1 - self.silent
        for inverted, chance in ((False, told * (1 - lie)), (True, told * lie), (None, self.silent)):
            if chance:
                yield inverted, chance


def acting_of(condition: str | Sequence[Intervention], p: float, flip: FlipKind, modality: str | None = None) -> Acting:
    """A condition, beside a flip rate, as chances.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, reports are flipped twice, or something acts
            whose course has to be sampled.
    """
    ones = interventions_of(condition) if isinstance(condition, str) else tuple(condition)
    flips = [one for one in ones if isinstance(one, OutcomeFlip)]
    if len(flips) + (p > 0) > 1:
        raise BadValue("condition", " + ".join(map(spec_of, ones)), "one flip at most, and none beside p")
    spoken = 1.0
    for one in ones:
        looping = isinstance(one, OutcomeFlip) and one.while_ != "always"
        if looping or not (isinstance(one, _FOLLOWED) or place_of(type(one)) == "asked"):
            raise BadValue("condition", spec_of(one), _KNOWN)
        spoken *= 1 - one.p if isinstance(one, Drop) else 1
    return Acting(
        flip=flips[0] if flips else OutcomeFlip(p=p, persistence=flip),
        silent=1 - spoken,
        states_only=tells_states_only(modality, flips[0].persistence if flips else flip),
        hands=tuple(one for one in ones if isinstance(one, Tremble | Force)),
    )


def tells_states_only(modality: str | None, flip: FlipKind) -> bool:
    """Whether a modality tells positions and no outcomes; studies' own if it is None.

    Raises:
        UserMistake: If it tells no positions, or shows the box otherwise than in words.
    """
    modality = modality or default_modality(flip)
    channel = shown(modality)
    if not isinstance(channel, TextChannel) or channel.tell == "outcome":
        known = "symbolic, or symbolic?tell=state, as which a viewer that sees well plays in pictures"
        raise BadValue("modality", modality, known)
    if channel.tell == "state" and flip == "outcome-only":
        raise BadValue("flip", flip, f"transient or sticky with {modality}, which tells positions alone")
    return channel.tell == "state"


_FOLLOWED = (OutcomeFlip, Drop, Tremble, Force, Reword)
