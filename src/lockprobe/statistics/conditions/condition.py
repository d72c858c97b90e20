"""The results of one agent under one condition, and the contrast of two conditions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import begun
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.conditions.axis_trials import Place, on_flip_axis
from lockprobe.statistics.curves import SuccessCurve, success_curve
from lockprobe.statistics.idle import never_acted
from lockprobe.statistics.inference.difference import AnyDifference, DifferenceAt
from lockprobe.statistics.outcomes import Outcomes, Point, broken_off, ended, outcomes, points
from lockprobe.statistics.proportions import ALPHA, Proportion, difference
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.sequential.shares import share_at_every_look
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary:
    """The results of one agent under one condition.

    Attributes:
        key: Its readable name, for example ``flips/random/flip?p=0.4``.
        name: Name of the condition.
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        dose: The dose on the axis of the analysis: the flip probability, [0, 1], or another dose.
        success: Share solved of the trials that ended as solved or out of budget, with an interval that holds whatever
            became of those that broke; players are clusters.
        errors: Trials that ended as error, by boundary.
        curve: Success by step.
        points: One point per repetition.
        distinct_sequences: Different sequences of actions among the ended trials. A deterministic agent told the truth
            plays one for each order of labels, however many trials there are.
        steps: The steps of ended trials.
        never_acted: Whether its interventions changed nothing, or it has a flip rate above 0 and no report was false.
    """

    key: str
    name: str
    agent: str
    modality: str
    dose: float
    success: Proportion
    errors: Mapping[str, int]
    curve: SuccessCurve
    points: tuple[Point, ...]
    distinct_sequences: int
    steps: int = 0
    never_acted: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """The contrast of the lowest p with the p whose success differs most clearly.

    Attributes:
        baseline: The condition at the lowest p.
        other: The condition with the smallest P value; of several the one with the largest difference.
        difference: Success at ``other`` minus success at ``baseline``, corrected for the choice of ``other``.
        choices: Number of conditions that ``other`` was chosen from.
        agents: Number of agents that are judged together; ``difference`` is corrected for them too.
        farthest: Whether no other p has a larger difference.
        fisher: P value of Fisher's exact test, which takes the trials as independent; not corrected.
    """

    baseline: ConditionSummary
    other: ConditionSummary
    difference: DifferenceAt
    choices: int
    agents: int
    farthest: bool
    fisher: float

    @property
    def detectable(self) -> bool:
        """Whether the difference is significant after correction for the choice and for the agents."""
        return self.difference.p_value < ALPHA

    @property
    def whole(self) -> bool:
        """Whether the sample holds all ended trials of both conditions."""
        compared = self.difference.first.n, self.difference.second.n
        return compared == (self.baseline.success.n, self.other.success.n)


def condition_summary(
    trials: Sequence[Trial],
    place: Callable[[Trial], Place] = on_flip_axis,
    order: BlockOrder | None = None,
) -> ConditionSummary:
    """The results of one agent's trials under one condition.

    ``place`` says where they are on the axis of the analysis, ``order`` the order of blocks if success must hold at
    every look.
    """
    agent, modality, dose = place(trials[0])
    found, broken = outcomes(trials, order=order), broken_off(trials, order=order)
    return ConditionSummary(
        key=trials[0].name.cell,
        name=trials[0].condition,
        agent=agent,
        modality=modality,
        dose=dose,
        success=_success(*begun(found, broken)),
        errors=dict(sorted(Counter(trial.error.boundary for trial in trials if trial.error).items())),
        curve=success_curve(found, broken, max(trial.budget for trial in trials)),
        points=tuple(replace(one, dose=dose) for one in points(found)),
        distinct_sequences=len({trial.actions for trial in ended(trials)}),
        steps=sum(len(trial.steps) for trial in ended(trials)),
        never_acted=never_acted(trials),
    )


def _success(every: Outcomes, solved: NDArray[np.float64]) -> Proportion:
    if every.order is None or every.crossed:
        return share_of(solved, every.player, every.luck)
    return share_at_every_look(solved[np.argsort(every.order.rank(every.repetition, every.trial))])


def condition_at(
    trials: Sequence[Trial],
    place: Callable[[Trial], Place],
    known: Mapping[tuple[str, str], ConditionSummary],
    order: BlockOrder | None = None,
) -> ConditionSummary:
    """The same as :func:`condition_summary`, from the results of the same trials on another axis where they are known.

    ``known`` has the results of agents under conditions, of all their trials.
    """
    names = {(trial.group, trial.condition) for trial in trials}
    found = known.get(names.pop()) if len(names) == 1 else None
    if found is None:
        return condition_summary(trials, place, order)
    agent, modality, dose = place(trials[0])
    moved = tuple(replace(one, dose=dose) for one in found.points)
    return replace(found, agent=agent, modality=modality, dose=dose, points=moved)


def contrast(conditions: Sequence[ConditionSummary], tested: AnyDifference) -> Contrast | None:
    """The contrast of the lowest p with the p that differs most clearly; None if no two can be compared."""
    found = tested.clearest
    if found is None:
        return None
    by_p = {condition.dose: condition for condition in conditions}
    independent = difference(found.first, found.second)
    assert tested.lowest is not None
    assert independent is not None
    return Contrast(
        baseline=by_p[tested.lowest],
        other=by_p[found.dose],
        difference=found,
        choices=len(tested.at),
        agents=tested.agents,
        farthest=abs(found.value) >= max(abs(one.value) for one in tested.at) - 1e-9,
        fisher=independent.p_value,
    )
