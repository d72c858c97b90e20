"""Misinterpretation rates: agents' claims about their last action, against report and truth (Sec. 3.1, Table 1).

- *misinterpretation*: the claim contradicts the report (the paper's "incorrect assessment of a state change").
- *false report*: the report contradicts the truth. The channel causes it.
- *false belief*: the claim contradicts the truth. A false report that is misread leaves a true belief.

The claim about step t stands in the decision of step t+1. The last step of a trial, and all steps of agents that are
not asked, have no claim. The paper does not say whether its rates are per step or per assessment; here they are per
claim.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from statistics import mean, stdev
from typing import get_args

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Proportion, proportion
from lockprobe.trial.record import Outcome, Step, Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """An agent's claim about one step.

    Attributes:
        step: From 1.
        claimed: The outcome as claimed.
        told: The outcome as reported.
        truth: The true outcome.
    """

    step: int
    claimed: Outcome
    told: Outcome
    truth: Outcome

    @property
    def misinterpreted(self) -> bool:
        """Whether the claim contradicts the report: the paper's misinterpretation."""
        return self.claimed != self.told

    @property
    def falsely_told(self) -> bool:
        """Whether the report contradicts the truth."""
        return self.told != self.truth

    @property
    def false_belief(self) -> bool:
        """Whether the claim contradicts the truth."""
        return self.claimed != self.truth


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaimCount:
    """The number of claims with one of the eight combinations of claim, report and truth; see :class:`Claim`."""

    claimed: Outcome
    told: Outcome
    truth: Outcome
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialClaims:
    """The claims of one trial.

    Attributes:
        key: Its readable name.
        claims: Every claim.
        steps: Steps played.
        false_reports: Steps whose report was false, claimed or not.
        positions_told: Steps whose report told positions.
        false_positions: Of these, steps whose report told a position falsely, of any joint.
    """

    key: str
    claims: tuple[Claim, ...]
    steps: int
    false_reports: int
    positions_told: int
    false_positions: int

    @property
    def misinterpreted(self) -> int:
        """Claims that contradict the report."""
        return sum(claim.misinterpreted for claim in self.claims)

    @property
    def falsely_told(self) -> int:
        """Claims about steps whose report was false."""
        return sum(claim.falsely_told for claim in self.claims)

    @property
    def false_beliefs(self) -> int:
        """Claims that contradict the truth."""
        return sum(claim.false_belief for claim in self.claims)

    @property
    def rate(self) -> float | None:
        """Misinterpretations over claims, [0, 1]; None without a claim."""
        return self.misinterpreted / len(self.claims) if self.claims else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Misinterpretations:
    """One row of the paper's Table 1, and pooled rates.

    Table 1 has ``mean_rate`` ± ``sd_rate``, ``total``, and ``affected`` of ``trials``. The other rates are pooled over
    trials. All intervals but ``pooled`` and ``against_truth`` take the trial as a cluster.

    Attributes:
        trials: Trials with at least one claim.
        affected: Trials with at least one misinterpretation.
        total: Misinterpretations over all trials.
        mean_rate: Mean over trials of each trial's own rate, [0, 1]; None without a claim.
        sd_rate: Standard deviation (n - 1) of those rates; None with fewer than two trials.
        pooled: Misinterpretations over claims, as if all claims were independent.
        against_truth: Claims that contradict the truth, over claims, as if all claims were independent.
        misinterpreted: Misinterpretations over claims.
        falsely_told: Claims about a step with a false report, over claims.
        false_reports: Steps whose report was false, over all steps of all trials.
        false_positions: Reports with a position that is false, over all reports of positions of all trials.
        false_belief: Claims that contradict the truth, over claims.
        moved_for_blocked: Share of claims "moved" among the claims about steps reported as blocked.
        blocked_for_moved: Share of claims "blocked" among the claims about steps reported as moved.
        hallucinated: Share of claims "moved" after the report "blocked" among all misinterpretations.
        counts: All eight combinations of (claimed, told, truth).
        not_asked: Trials in which the agent was not asked what its actions did.
    """

    trials: int
    affected: int
    total: int
    mean_rate: float | None
    sd_rate: float | None
    pooled: Proportion
    against_truth: Proportion
    misinterpreted: ClusteredProportion
    falsely_told: ClusteredProportion
    false_reports: ClusteredProportion
    false_positions: ClusteredProportion
    false_belief: ClusteredProportion
    moved_for_blocked: ClusteredProportion
    blocked_for_moved: ClusteredProportion
    hallucinated: ClusteredProportion
    counts: tuple[ClaimCount, ...]
    not_asked: int

    @property
    def believed(self) -> int:
        """False reports that were believed."""
        return self._count(misread=False, false=True)

    @property
    def undone(self) -> int:
        """False reports that were misread, so that the claim was true."""
        return self._count(misread=True, false=True)

    @property
    def misread(self) -> int:
        """True reports that were misread."""
        return self._count(misread=True, false=False)

    def _count(self, *, misread: bool, false: bool) -> int:
        return sum(
            kind.count
            for kind in self.counts
            if (kind.claimed != kind.told) == misread and (kind.told != kind.truth) == false
        )


def claims(trial: Trial) -> list[Claim]:
    """Every claim of a trial about a step that was reported, with the report and the truth."""
    return [
        Claim(
            step=step.step,
            claimed=said,
            told=_outcome(moved=step.told_moved),
            truth=_outcome(moved=step.moved),
        )
        for step, said in zip(trial.steps, trial.said, strict=True)
        if said is not None and step.told_moved is not None
    ]


def _outcome(*, moved: bool) -> Outcome:
    return "moved" if moved else "blocked"


def trial_claims(trial: Trial) -> TrialClaims:
    """The claims of one trial, and how often its reports were false."""
    return TrialClaims(
        key=trial.key,
        claims=tuple(claims(trial)),
        steps=len(trial.steps),
        false_reports=sum(step.told_falsely for step in trial.steps),
        positions_told=sum(step.told_state is not None for step in trial.steps),
        false_positions=sum(
            step.told_state is not None and step.told_state != _state_after(trial, step) for step in trial.steps
        ),
    )


def _state_after(trial: Trial, step: Step) -> str:
    """The true configuration after a step, a bit string in panel order."""
    place = trial.joints.index(step.joint)
    turned = "10"[int(step.state[place])]
    return f"{step.state[:place]}{turned}{step.state[place + 1 :]}" if step.moved else step.state


def misinterpretations(trials: Sequence[Trial]) -> Misinterpretations:
    """The misinterpretations in the trials of one condition; error trials are left out."""
    counted = [trial_claims(trial) for trial in ended(trials)]
    asked = [trial for trial in counted if trial.claims]
    rates = [rate for trial in asked if (rate := trial.rate) is not None]
    made = [len(trial.claims) for trial in asked]
    wrong = [trial.misinterpreted for trial in asked]
    untrue = [trial.false_beliefs for trial in asked]
    kinds = Counter((claim.claimed, claim.told, claim.truth) for trial in asked for claim in trial.claims)
    return Misinterpretations(
        trials=len(asked),
        affected=sum(count > 0 for count in wrong),
        total=sum(wrong),
        mean_rate=mean(rates) if rates else None,
        sd_rate=stdev(rates) if len(rates) > 1 else None,
        pooled=proportion(sum(wrong), sum(made)),
        against_truth=proportion(sum(untrue), sum(made)),
        misinterpreted=clustered_proportion(wrong, made),
        falsely_told=clustered_proportion([trial.falsely_told for trial in asked], made),
        false_reports=clustered_proportion(
            [trial.false_reports for trial in counted], [trial.steps for trial in counted]
        ),
        false_positions=clustered_proportion(
            [trial.false_positions for trial in counted], [trial.positions_told for trial in counted]
        ),
        false_belief=clustered_proportion(untrue, made),
        moved_for_blocked=_misread(asked, "blocked"),
        blocked_for_moved=_misread(asked, "moved"),
        hallucinated=clustered_proportion(
            [sum(c.misinterpreted and c.told == "blocked" for c in trial.claims) for trial in asked], wrong
        ),
        counts=tuple(
            ClaimCount(claimed=claimed, told=told, truth=truth, count=kinds[claimed, told, truth])
            for claimed, told, truth in product(get_args(Outcome), repeat=3)
        ),
        not_asked=sum(not trial.assessment for trial in ended(trials)),
    )


def misread_in_blocks(trials: Sequence[Trial]) -> ClusteredProportion:
    """Misinterpretations over claims, pooled over conditions; trials of equal number share their luck, and a cluster.

    Error trials are left out.
    """
    blocks = grouped(ended(trials), lambda trial: (trial.repetition, trial.trial)).values()
    counted = [[claim.misinterpreted for trial in block for claim in claims(trial)] for block in blocks]
    asked = [block for block in counted if block]
    return clustered_proportion(list(map(sum, asked)), list(map(len, asked)))


def _misread(asked: Sequence[TrialClaims], told: Outcome) -> ClusteredProportion:
    """Misinterpretations of reports with this outcome, over the claims about such reports."""
    about = [found for trial in asked if (found := [claim for claim in trial.claims if claim.told == told])]
    return clustered_proportion(
        [sum(claim.misinterpreted for claim in found) for found in about], list(map(len, about))
    )
