"""One agent under one condition in numbers, and two of its conditions held against each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lockprobe.analysis.behaviour import Behaviour, behaviour
from lockprobe.analysis.curves import Relative, SuccessCurve, relative, success_curve
from lockprobe.analysis.inference.peak import AnyDifference
from lockprobe.analysis.misinterpretation import Misinterpretations, misinterpretations
from lockprobe.analysis.outcomes import Outcomes, Point, outcomes, points, solved_in_pairs
from lockprobe.analysis.persistence import Persistence, persistence
from lockprobe.analysis.proportions import ALPHA, Difference, Paired, Proportion, difference, paired, proportion
from lockprobe.analysis.rationality import Rationality, rationality
from lockprobe.analysis.reference import Reference
from lockprobe.record import Trial

__all__ = ["ConditionSummary", "Contrast", "condition_summary", "contrast"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary:
    """One agent under one condition.

    Attributes:
        key: Its readable name, for example ``flips/random/p=0.4``.
        agent: Agent spec.
        modality: How the box was shown.
        p: Flip probability, [0, 1].
        success: Solved trials of those that ended as solved or out of budget.
        errors: Trials that ended as error, by boundary; in no other number.
        curve: Success by step.
        relative: The same between a random agent and the optimum; None where the box is not known.
        behaviour: Loops, redundancy, entropy.
        persistence: Whether loops are left, and blocked joints tried again.
        claims: Misinterpretations.
        rationality: Its actions before two ideal observers; empty where the box is too large for a prior.
        points: One per repetition.
    """

    key: str
    agent: str
    modality: str
    p: float
    success: Proportion
    errors: Mapping[str, int]
    curve: SuccessCurve
    relative: Relative | None
    behaviour: Behaviour
    persistence: Persistence
    claims: Misinterpretations
    rationality: tuple[Rationality, ...]
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """The condition with the fewest flips against the one whose success lies farthest from it.

    Attributes:
        baseline: The lower p.
        other: The p whose success differs most.
        difference: Success at ``other`` minus success at ``baseline``, taken as independent.
        paired: The same over trials that both have, which share their luck; intervals are corrected for the choice.
        choices: Number of conditions that ``other`` was chosen from.
        p_adjusted: Permutation within trials that share their luck, corrected for the choice.
    """

    baseline: ConditionSummary
    other: ConditionSummary
    difference: Difference
    paired: Paired
    choices: int
    p_adjusted: float

    @property
    def detectable(self) -> bool:
        """Whether the difference is more than chance and the choice of the best would explain."""
        return self.p_adjusted < ALPHA


def condition_summary(trials: Sequence[Trial], reference: Reference | None) -> ConditionSummary:
    """The numbers of the trials of one agent, modality and p."""
    first = trials[0]
    curve = success_curve(trials)
    budget = len(curve.share)
    return ConditionSummary(
        key=first.condition,
        agent=first.group,
        modality=first.modality,
        p=first.p,
        success=proportion(len(curve.solved_at), curve.n),
        errors=dict(sorted(Counter(trial.error.boundary for trial in trials if trial.error).items())),
        curve=curve,
        relative=relative(curve, reference.random[:budget], reference.optimum) if reference else None,
        behaviour=behaviour(trials),
        persistence=persistence(trials),
        claims=misinterpretations(trials),
        rationality=rationality(trials),
        points=tuple(points(outcomes(trials))),
    )


def contrast(conditions: Sequence[ConditionSummary], counted: Outcomes, tested: AnyDifference) -> Contrast | None:
    """The lowest p against the one farthest from it; None with fewer than two that have trials that ended."""
    played = [condition for condition in conditions if condition.success.n]
    if len(played) < 2:
        return None
    baseline, *others = played
    other = max(others, key=lambda condition: abs(condition.success.value - baseline.success.value))
    found = difference(baseline.success, other.success, choices=len(others))
    adjusted = next((at.p_value for at in tested.at if at.p == other.p), None)
    if found is None or adjusted is None:
        return None
    pairs = solved_in_pairs(*(counted.at(counted.p == condition.p) for condition in (baseline, other)))
    return Contrast(
        baseline=baseline,
        other=other,
        difference=found,
        paired=paired(pairs[:, 0], pairs[:, 1], choices=len(others)),
        choices=len(others),
        p_adjusted=adjusted,
    )
