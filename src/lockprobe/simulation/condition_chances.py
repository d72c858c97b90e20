"""Conditions as probabilities, for exact propagation: they may depend on step and outcome alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple, get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.validation import check_choice, check_number
from lockprobe.interventions.asked import Distract
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.conditions import blind
from lockprobe.interventions.done import Force, Tremble
from lockprobe.interventions.flip import FlipKind, OutcomeFlip, flip_of
from lockprobe.interventions.told import Correction, Drop, Phantom
from lockprobe.interventions.words import Tell, TextChannel
from lockprobe.studies.modality import shown
from lockprobe.trial.condition import place_of, spec_of
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES
from lockprobe.trial.source import source_of

_KNOWN = (
    "flip (but while=looping), phantom, correction, drop, tremble (but at), force (but joint) and what is asked; "
    "sample others (lockprobe.run_trial)"
)


class Report(NamedTuple):
    """One possible report.

    Whether it is inverted (None: not given), its probability, whether the first statement that it corrects is inverted
    (None: it corrects none), whether a remark comes with it, and whether it has a phantom.
    """

    inverted: bool | None
    chance: float
    corrects: bool | None = None
    remarked: bool = False
    phantom: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionChances:
    """A condition as probabilities.

    Attributes:
        flip: The outcome flip; of several, the first; with a correction, the flip whose lies it tells.
        later: Further flips; at most one flip applies to each step.
        withheld: Probability that no report is given, with the same random number as ``flip``, [0, 1].
        correction: The correction, with the same random number; None without one.
        distracted: Probability of a remark, with the same random number, [0, 1].
        phantom: Probability of a phantom, with the same random number, [0, 1].
        lost: Probability that a report is lost independently of the flip, [0, 1].
        remarked: Probability of a remark, independently of the flip, [0, 1].
        tell: Whether positions are told, outcomes, or both.
        hands: Interventions that change the attempted joint, in order.
        asks: Whether an intervention other than ``distract`` acts on what is asked.
    """

    flip: OutcomeFlip
    later: tuple[OutcomeFlip, ...] = ()
    withheld: float = 0.0
    correction: Correction | None = None
    distracted: float = 0.0
    phantom: float = 0.0
    lost: float = 0.0
    remarked: float = 0.0
    tell: Tell = "both"
    hands: tuple[Tremble | Force, ...] = ()
    asks: bool = False

    def phase(self, step: int) -> Hashable:
        """A key that is equal for steps with equal probabilities."""
        flip = self._flip_at(step)
        return flip and (flip.p, flip.only), *(isinstance(hand, Force) and hand.at == step for hand in self.hands)

    def _flip_at(self, step: int) -> OutcomeFlip | None:
        """The flip that applies to a step."""
        return next((one for one in (self.flip, *self.later) if one.falls_on(step)), None)

    def attempted(self, chances: Sequence[float], step: int) -> Sequence[float]:
        """The probability that each joint is attempted, given the probabilities of the agent's choice."""
        for hand in self.hands:
            if isinstance(hand, Tremble):
                others = len(chances) - 1
                chances = [(1 - hand.p) * chance + hand.p * (1 - chance) / others for chance in chances]
            elif hand.at == step:
                chances = [1 / len(chances)] * len(chances)
        return chances

    def reports(self, step: int, *, moved: bool) -> list[Report]:
        """The possible reports of an outcome. Interventions that share the flip's random number hit the same steps."""
        flip = self._flip_at(step)
        lie = flip.p if flip is not None and flip.only in ("any", "moved" if moved else "blocked") else 0.0
        corrected = 0.0 if self.correction is None else self.correction.p
        found: dict[tuple[bool | None, bool | None, bool, bool], float] = defaultdict(float)
        edges = sorted({0.0, lie, self.withheld, corrected, self.distracted, self.phantom, 1.0})
        for low, high in pairwise(edges):
            inverted = None if low < self.withheld else low < lie
            first = self.correction.first == "lie" if self.correction and low < corrected else None
            for lost, unless in ((True, self.lost), (False, 1 - self.lost)):
                for remarked, chance in ((True, self.remarked), (False, 1 - self.remarked)):
                    case = None if lost else inverted, first, low < self.distracted or remarked, low < self.phantom
                    found[case] += (high - low) * unless * chance
        return [Report(case[0], chance, *case[1:]) for case, chance in found.items() if chance]

    def noise(self, step: int) -> float:
        """The probability that the position of a joint that is not attempted is inverted in a report, [0, 1]."""
        flip = self._flip_at(step)
        return flip.p if flip is not None and flip.others == "noisy" else 0.0


def condition_chances(
    condition: str | Sequence[Intervention], p: float, flip: FlipKind, modality: str | None = None, *, budget: int = 20
) -> ConditionChances:
    """A condition with a flip rate, as probabilities.

    The arguments are those of :func:`lockprobe.propagate`. Several flips are allowed if at most one applies to each
    step of the budget; the flip rate then changes over steps.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, a report is flipped twice, or an intervention
            has to be sampled.
    """
    check_number("flip rate p", p)
    if not isinstance(condition, str | Sequence):
        raise BadValue("condition", condition, "a spec, or a list of interventions")
    if isinstance(condition, str):
        allow(condition)
    ones = interventions_of(condition) if isinstance(condition, str) else tuple(condition)
    flips = [one for one in ones if isinstance(one, OutcomeFlip)]
    twice = any(sum(one.falls_on(step) for one in flips) > 1 for step in range(1, budget + 1))
    lasting = any(one.keep for one in flips) or len({(one.inverts, one.others, one.part) for one in flips}) > 1
    if twice or (flips and p > 0) or (len(flips) > 1 and lasting):
        expected = "one flip a step at most, several only without keep and of one reading, and none with p"
        raise BadValue("condition", " + ".join(map(spec_of, ones)), expected)
    phantoms = [one.p for one in ones if isinstance(one, Phantom)]
    corrections = [one for one in ones if isinstance(one, Correction)]
    if len(phantoms) + len(corrections) > 1 or ((phantoms or corrections) and (flips or p > 0)):
        expected = "one phantom or correction at most, and none with a flip; sample others (lockprobe.run_trial)"
        raise BadValue("condition", " + ".join(map(spec_of, ones)), expected)
    acting = OutcomeFlip(inverts="position") if phantoms else flip_of(flip, p)  # nothing compares with what was told
    for corrected in corrections:
        acting = corrected.lies if corrected.last == "lie" else corrected.lies.at_rate(0)
    at_the_flips: dict[type[Any], float] = {}
    spoken = {Drop: 1.0, Distract: 1.0}
    for one in ones:
        looping = isinstance(one, OutcomeFlip) and one.while_ != "always"
        limited = isinstance(one, Correction | Drop | Distract | Tremble) and one.at
        named = isinstance(one, Force) and one.joint
        if looping or limited or named or not (isinstance(one, _FOLLOWED) or place_of(type(one)) == "asked"):
            raise BadValue("condition", spec_of(one), _KNOWN)
        if isinstance(one, Drop | Distract) and one.luck == "own":
            spoken[type(one)] *= 1 - one.p
        elif isinstance(one, Drop | Distract):
            at_the_flips[type(one)] = max(one.p, at_the_flips.get(type(one), 0.0))
    return ConditionChances(
        flip=flips[0] if flips else acting,
        later=tuple(flips[1:]),
        withheld=at_the_flips.get(Drop, 0.0),
        correction=corrections[0] if corrections else None,
        distracted=at_the_flips.get(Distract, 0.0),
        phantom=sum(phantoms),
        lost=1 - spoken[Drop],
        remarked=1 - spoken[Distract],
        tell=told_by(modality, flip),
        hands=tuple(one for one in ones if isinstance(one, Tremble | Force)),
        asks=any(place_of(type(one)) == "asked" and not isinstance(one, Distract) for one in ones),
    )


def told_by(modality: str | None, flip: FlipKind) -> Tell:
    """What a modality tells; None means the default of studies, and ``outcome-only`` makes it blind.

    Raises:
        UserMistake: If it shows the box in pictures, or shows positions under ``outcome-only``.
    """
    check_choice("flip", flip, get_args(FlipKind))
    if not isinstance(modality, str | None):
        raise BadValue("modality", modality, "a text, such as symbolic")
    if flip == "outcome-only":
        modality = blind(modality or "symbolic")
    channel = shown(modality or STATES)
    if (source := source_of(modality or STATES)) is not None and source.of != "truth":
        raise BadValue("modality", modality, f"symbolic without source={source.of}, whose errors only a plant makes")
    if not isinstance(channel, TextChannel):
        known = "symbolic, or symbolic?tell=state, as which a viewer that sees well plays in pictures"
        raise BadValue("modality", modality, known)
    return channel.tell


_FOLLOWED = (OutcomeFlip, Phantom, Correction, Drop, Distract, Tremble, Force)
