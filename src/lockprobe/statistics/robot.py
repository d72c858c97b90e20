"""What an arm and a camera took the attempts for, against the truth and against each other, joint by joint."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion
from lockprobe.trial.record import Trial
from lockprobe.trial.source import CAMERA, VERDICT, camera_outcomes, verdict_outcomes


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """The outcomes of attempts as an arm or a camera judged them.

    Attributes:
        attempts: Attempts that it should have judged.
        undecided: Those that it could not: the arm had no grip or no conclusion, the camera saw the joint unclearly.
        right: Share of its outcomes "moved" and "blocked" that are true.
        moved_for_blocked: False outcomes "moved".
        blocked_for_moved: False outcomes "blocked".
    """

    attempts: int
    undecided: int
    right: ClusteredProportion
    moved_for_blocked: int
    blocked_for_moved: int

    @property
    def wrong(self) -> ClusteredProportion:
        """The share of outcomes that are not true, with the same interval from its other side."""
        right = self.right
        count, value, low, high = right.n - right.count, 1 - right.value, 1 - right.high, 1 - right.low
        return replace(right, count=count, value=value, low=low, high=high)


@dataclass(frozen=True, slots=True, kw_only=True)
class SensedAttempts:
    """Attempts at one joint or at all, with shares clustered by luck.

    Attributes:
        attempts: Attempts with a verdict or a camera's reading.
        moved: Those at which the joint really moved.
        verdict: The arm's verdicts; None without an arm.
        camera: The outcomes by the camera's readings; None if it was not read.
        agree: Share of attempts decided by both at which verdict and camera agree; None without both.
    """

    attempts: int
    moved: int
    verdict: Judged | None
    camera: Judged | None
    agree: ClusteredProportion | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSenses:
    """What a robot took its attempts for.

    Attributes:
        all: All attempts.
        joints: Those at each joint, by name, in the panel order of the first trial.
    """

    all: SensedAttempts
    joints: Mapping[str, SensedAttempts]


@dataclass(frozen=True, slots=True)
class _Attempt:
    """One attempt: its luck, its joint, the truth, and what arm and camera took it for; None for undecided."""

    luck: Hashable
    joint: str
    moved: bool
    has_verdict: bool
    verdict: bool | None
    has_reading: bool
    camera: bool | None


def robot_senses(trials: Sequence[Trial]) -> RobotSenses | None:
    """Count what an arm and a camera took attempts for, also in trials that broke later.

    Returns:
        None if no step has a verdict or a reading.
    """
    sensing = [trial for trial in trials if any(step.sensed for step in trial.steps)]
    attempts = [one for trial in sensing for one in _attempts(trial) if one.has_verdict or one.has_reading]
    if not attempts:
        return None
    names = dict.fromkeys(joint for trial in trials for joint in trial.joints)
    by_joint = {name: [one for one in attempts if one.joint == name] for name in names}
    return RobotSenses(
        all=_sensed(attempts),
        joints={name: _sensed(members) for name, members in by_joint.items() if members},
    )


def _attempts(trial: Trial) -> list[_Attempt]:
    return [
        _Attempt(
            luck=(trial.repetition, trial.trial),
            joint=step.joint,
            moved=step.moved,
            has_verdict=VERDICT in step.sensed,
            verdict=verdict,
            has_reading=CAMERA in step.sensed,
            camera=seen,
        )
        for step, verdict, seen in zip(trial.steps, verdict_outcomes(trial), camera_outcomes(trial), strict=True)
    ]


def _sensed(attempts: Sequence[_Attempt]) -> SensedAttempts:
    both = [one for one in attempts if one.verdict is not None and one.camera is not None]
    verdicts = [(one, one.verdict) for one in attempts if one.has_verdict]
    readings = [(one, one.camera) for one in attempts if one.has_reading]
    return SensedAttempts(
        attempts=len(attempts),
        moved=sum(one.moved for one in attempts),
        verdict=_judged(verdicts) if verdicts else None,
        camera=_judged(readings) if readings else None,
        agree=_share(both, lambda one: one.verdict == one.camera) if verdicts and readings else None,
    )


def _judged(outcomes: Sequence[tuple[_Attempt, bool | None]]) -> Judged:
    decided = [(one, moved) for one, moved in outcomes if moved is not None]
    right = {id(one) for one, moved in decided if moved == one.moved}
    return Judged(
        attempts=len(outcomes),
        undecided=len(outcomes) - len(decided),
        right=_share([one for one, _ in decided], lambda one: id(one) in right),
        moved_for_blocked=sum(moved and not one.moved for one, moved in decided),
        blocked_for_moved=sum(one.moved and not moved for one, moved in decided),
    )


def _share(attempts: Sequence[_Attempt], counts: Callable[[_Attempt], bool]) -> ClusteredProportion:
    """The share of attempts that count, clustered by luck."""
    by_luck = defaultdict[Hashable, list[bool]](list)
    for one in attempts:
        by_luck[one.luck].append(counts(one))
    return clustered_proportion(list(map(sum, by_luck.values())), list(map(len, by_luck.values())))
