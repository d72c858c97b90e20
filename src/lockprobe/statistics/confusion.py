"""The confusion matrix of an agent: how often it misread what its attempts did, by joint and by true outcome.

A *hidden move* is a move that the agent took for a failure, an *invented move* a failure that it took for a move. What
an agent said is compared with what happened; with true reports these are its misinterpretations (paper, Sec. 3.1).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.outcomes import ended
from lockprobe.trial.record import Outcome, Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class Confusion:
    """Counts of claims about attempts, and of those that were wrong, by joint and true outcome.

    Attributes:
        joints: Names of the joints.
        made: (joint, true outcome) -> claims.
        wrong: (joint, true outcome) -> claims that contradict it.
    """

    joints: tuple[str, ...]
    made: Mapping[tuple[str, Outcome], int]
    wrong: Mapping[tuple[str, Outcome], int]

    @property
    def claims(self) -> int:
        """All claims."""
        return sum(self.made.values())

    @property
    def misread(self) -> int:
        """All wrong claims."""
        return sum(self.wrong.values())

    def count(self, outcome: Outcome, joint: str | None = None) -> tuple[int, int]:
        """Wrong claims and all claims about attempts with this outcome, of one joint or of all."""
        joints = self.joints if joint is None else (joint,)
        wrong, made = (sum(counts.get((one, outcome), 0) for one in joints) for counts in (self.wrong, self.made))
        return wrong, made

    def rates(
        self, by: Literal["joint", "direction", "total"] = "joint", joints: Sequence[str] = ()
    ) -> dict[str, tuple[float, float]]:
        """Joint -> the rates of hidden and of invented moves, [0, 1].

        A joint without a claim about an outcome has the rate of that outcome over all joints; an outcome without a
        claim has the rate 0.

        Args:
            by: Whether the rates are those of the joint and outcome, of the outcome, or the total rate.
            joints: The joints; those of the trials if empty.
        """
        joints = joints or self.joints
        if by == "total":
            rate = _rate(self.misread, self.claims)
            return dict.fromkeys(joints, (rate, rate))
        return {joint: (self._rate(joint, "moved", by), self._rate(joint, "blocked", by)) for joint in joints}

    def _rate(self, joint: str, outcome: Outcome, by: str) -> float:
        own = self.count(outcome, joint)
        return _rate(*own) if by == "joint" and own[1] else _rate(*self.count(outcome))


def _rate(wrong: int, made: int) -> float:
    return wrong / made if made else 0.0


def confusion(trials: Sequence[Trial]) -> Confusion:
    """The confusion matrix of the trials of one agent; trials that ended as an error are left out."""
    made, wrong = Counter[tuple[str, Outcome]](), Counter[tuple[str, Outcome]]()
    joints = dict[str, None]()
    for trial in ended(trials):
        joints |= dict.fromkeys(sorted(trial.joints))
        for claim in claims(trial):
            kind = trial.steps[claim.step - 1].joint, claim.truth
            made[kind] += 1
            wrong[kind] += claim.false_belief
    return Confusion(joints=tuple(joints), made=made, wrong=wrong)
