"""What agents claim of their last action, against report and truth (paper, Sec. 3.1).

- *misinterpretation*: the claim contradicts the report (the paper's "incorrect assessment of a state change").
- *false report*: the report contradicts the truth. The channel causes it.
- *false belief*: the claim contradicts the truth. A false report that is misread leaves a true belief.

The claim about step t stands in the decision of step t+1. The last step of a trial, and all steps of agents that are
not asked, have no claim.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from lockprobe.statistics.outcomes import ended
from lockprobe.trial.record import Outcome, Trial


class Claim(NamedTuple):
    """An agent's claim about the attempt at a joint, the report of it, and the truth."""

    joint: str
    claimed: Outcome
    told: Outcome
    truth: Outcome

    @property
    def misread(self) -> bool:
        """Whether it contradicts the report: the paper's misinterpretation."""
        return self.claimed != self.told

    @property
    def falsely_told(self) -> bool:
        """Whether the report contradicts the truth."""
        return self.told != self.truth

    @property
    def false_belief(self) -> bool:
        """Whether it contradicts the truth."""
        return self.claimed != self.truth


def claims(trial: Trial) -> list[Claim]:
    """Every claim of a trial about a step that was reported."""
    words: tuple[Outcome, Outcome] = ("blocked", "moved")
    return [
        Claim(step.joint, said, words[bool(step.told_moved)], words[bool(step.moved)])
        for step, said in zip(trial.steps, trial.said, strict=True)
        if said is not None and step.told_moved is not None
    ]


def claim_counts(trials: Iterable[Trial]) -> Counter[Claim]:
    """How often each claim was made in trials that ended as solved or out of budget."""
    return Counter(claim for trial in ended(trials) for claim in claims(trial))
