"""The results of one agent under one condition, and the contrast of two conditions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lockprobe.analysis.behaviour import Behaviour, behaviour
from lockprobe.analysis.clustered import share_of
from lockprobe.analysis.curves import Relative, SuccessCurve, relative, success_curve
from lockprobe.analysis.inference.difference import AnyDifference, DifferenceAt
from lockprobe.analysis.misinterpretation import Misinterpretations, misinterpretations
from lockprobe.analysis.outcomes import Point, outcomes, points
from lockprobe.analysis.persistence import Persistence, persistence
from lockprobe.analysis.proportions import ALPHA, Proportion, difference
from lockprobe.analysis.rationality import Rationality, rationality
from lockprobe.analysis.reference import Reference
from lockprobe.record import Trial

__all__ = ["ConditionSummary", "Contrast", "condition_summary", "contrast"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary:
    """One agent under one condition.

    Attributes:
        key: Its readable name, for example ``flips/random/p=0.4``.
        name: Name of the condition.
        agent: Agent spec.
        modality: How the box was shown.
        p: Its dose on the axis of the analysis: the flip probability, [0, 1], or another.
        success: Solved trials of those that ended as solved or out of budget; players are clusters.
        errors: Trials that ended as error, by boundary; in no other number.
        curve: Success by step.
        relative: The same between a random agent and the optimum; None where the box is not known.
        behaviour: Loops, redundancy, entropy.
        persistence: Whether loops are left, and blocked joints tried again.
        claims: Misinterpretations.
        rationality: Its actions judged by two ideal observers; empty where the box is too large for a prior.
        points: One per repetition.
    """

    key: str
    name: str
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
    """The condition with the fewest flips against the condition whose success differs most clearly.

    Attributes:
        baseline: The lower p.
        other: The p with the smallest p-value; of several the farthest.
        difference: Success at ``other`` less success at ``baseline``, corrected for the choice.
        choices: Number of conditions that ``other`` was chosen from.
        farthest: Whether no other p differs by more.
        fisher: Fisher's exact test of the same trials as independent; not corrected.
    """

    baseline: ConditionSummary
    other: ConditionSummary
    difference: DifferenceAt
    choices: int
    farthest: bool
    fisher: float

    @property
    def detectable(self) -> bool:
        """Whether the difference is significant after correction for the choice."""
        return self.difference.p_value < ALPHA

    @property
    def whole(self) -> bool:
        """Whether the sample holds all trials of both conditions that ended."""
        compared = self.difference.first.n, self.difference.second.n
        return compared == (self.baseline.success.n, self.other.success.n)


def condition_summary(trials: Sequence[Trial], reference: Reference | None) -> ConditionSummary:
    """The numbers of the trials of one agent, modality and p."""
    first = trials[0]
    curve, found = success_curve(trials), outcomes(trials)
    budget = len(curve.share)
    return ConditionSummary(
        key=first.cell,
        name=first.condition or first.cell.removeprefix(f"{first.study}/{first.group}/"),
        agent=first.group,
        modality=first.modality,
        p=first.dose,
        success=share_of(found.solved, found.player, found.luck),
        errors=dict(sorted(Counter(trial.error.boundary for trial in trials if trial.error).items())),
        curve=curve,
        relative=relative(curve, reference.random[:budget], reference.optimum) if reference else None,
        behaviour=behaviour(trials),
        persistence=persistence(trials),
        claims=misinterpretations(trials),
        rationality=rationality(trials),
        points=tuple(points(found)),
    )


def contrast(conditions: Sequence[ConditionSummary], tested: AnyDifference) -> Contrast | None:
    """The lowest p against the p that differs most clearly; None where no two can be compared."""
    found = tested.clearest
    if found is None:
        return None
    by_p = {condition.p: condition for condition in conditions}
    independent = difference(found.first, found.second)
    assert tested.lowest is not None
    assert independent is not None
    return Contrast(
        baseline=by_p[tested.lowest],
        other=by_p[found.p],
        difference=found,
        choices=len(tested.at),
        farthest=abs(found.value) >= max(abs(one.value) for one in tested.at) - 1e-9,
        fisher=independent.p_value,
    )
