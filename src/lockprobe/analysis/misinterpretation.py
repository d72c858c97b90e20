"""What agents say their action did, held against what they were told of it (paper, Sec. 3.1 and Table 1).

The claim about step t stands in the decision of step t+1. Steps without a claim (the last one of every trial, and
all steps of agents that are not asked) are not counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import mean, stdev

from lockprobe.analysis.outcomes import ended
from lockprobe.analysis.proportions import Proportion, proportion
from lockprobe.record import Outcome, Step, Trial

__all__ = ["Claim", "Misinterpretations", "claims", "misinterpretations"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """What an agent said of one step.

    Attributes:
        step: The step it spoke of, from 1.
        claimed: What it said had happened.
        told: What it had been told.
        truth: What had really happened.
    """

    step: int
    claimed: Outcome
    told: Outcome
    truth: Outcome

    @property
    def misinterpreted(self) -> bool:
        """Whether the claim contradicts what was told: the paper's misinterpretation."""
        return self.claimed != self.told


@dataclass(frozen=True, slots=True, kw_only=True)
class Misinterpretations:
    """One row of the paper's Table 1, and what it takes to check it.

    A misinterpretation is an incorrect assessment of a change of state (Sec. 3.1): the claim contradicts what
    was *told*. An agent that believes a false report has understood it correctly; how often its claim
    contradicts the truth is counted apart.

    Attributes:
        trials: Trials with at least one claim.
        affected: Trials with at least one misinterpretation.
        total: Misinterpretations over all trials.
        mean_rate: Mean over trials of each trial's own rate, [0, 1]; None without a claim.
        sd_rate: Standard deviation (n - 1) of those rates; None with fewer than two trials.
        pooled: Misinterpretations over claims.
        against_truth: Claims that contradict the truth, over claims.
    """

    trials: int
    affected: int
    total: int
    mean_rate: float | None
    sd_rate: float | None
    pooled: Proportion
    against_truth: Proportion


def claims(trial: Trial) -> list[Claim]:
    """Every claim of a trial beside what was told and what was true."""
    return [
        Claim(
            step=step.step,
            claimed=after.decision.claimed,
            told=_outcome(moved=step.told_moved),
            truth=_outcome(moved=step.moved),
        )
        for step, after in _pairs(trial)
        if after.decision.claimed is not None
    ]


def _pairs(trial: Trial) -> zip[tuple[Step, Step]]:
    return zip(trial.steps, trial.steps[1:], strict=False)


def _outcome(*, moved: bool) -> Outcome:
    return "moved" if moved else "blocked"


def misinterpretations(trials: Sequence[Trial]) -> Misinterpretations:
    """Count over the trials of one condition; error trials are left out."""
    per_trial = [found for trial in ended(trials) if (found := claims(trial))]
    wrong = [sum(claim.misinterpreted for claim in found) for found in per_trial]
    rates = [count / len(found) for count, found in zip(wrong, per_trial, strict=True)]
    made = sum(map(len, per_trial))
    untrue = sum(claim.claimed != claim.truth for found in per_trial for claim in found)
    return Misinterpretations(
        trials=len(per_trial),
        affected=sum(count > 0 for count in wrong),
        total=sum(wrong),
        mean_rate=mean(rates) if rates else None,
        sd_rate=stdev(rates) if len(rates) > 1 else None,
        pooled=proportion(sum(wrong), made),
        against_truth=proportion(untrue, made),
    )
