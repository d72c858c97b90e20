"""Attempts against the rules of the box: the interlock let a joint move and it did not, or the reverse.

A simulation of the rules has none. A hand misses, slips or pushes another joint; a person who moves a box by hand errs.
Such an attempt says nothing of the agent that chose it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from itertools import zip_longest

from lockprobe.boxes.box import Lockbox
from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion, crossed_proportion
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleBreaks:
    """Attempts against the rules of the box, including those of trials that broke later.

    Attributes:
        attempts: All attempts.
        against: Attempts against the rules: missed, forced, or with another joint moved.
        free: Attempts at joints that the interlock let move.
        missed: Of these, attempts that moved nothing.
        forced: Attempts that moved a joint that was locked.
        others: Attempts after which another joint than the attempted one had changed its position.
    """

    attempts: int
    against: int
    free: int
    missed: int
    forced: int
    others: int


def together(found: Iterable[RuleBreaks | None]) -> RuleBreaks | None:
    """The attempts of several conditions; None if they are known of none."""
    known = [one for one in found if one is not None]
    return (
        RuleBreaks(**{field.name: sum(getattr(one, field.name) for one in known) for field in fields(RuleBreaks)})
        if known
        else None
    )


def rule_breaks(trials: Sequence[Trial], box: Lockbox) -> RuleBreaks | None:
    """Count the attempts against the rules of a box; None if the trials are of other joints."""
    judged = [one for trial in trials for one in against_rules(trial, box)]
    if not judged and any(trial.steps for trial in trials):
        return None
    return RuleBreaks(
        attempts=len(judged),
        against=sum(one.against for one in judged),
        free=sum(one.free for one in judged),
        missed=sum(one.missed for one in judged),
        forced=sum(one.forced for one in judged),
        others=sum(one.other for one in judged),
    )


@dataclass(frozen=True, slots=True)
class Judged:
    """One attempt before the rules: whether the joint was free, whether it moved, and whether another one changed."""

    free: bool
    moved: bool
    other: bool

    @property
    def missed(self) -> bool:
        """Whether the joint was free and did not move."""
        return self.free and not self.moved

    @property
    def forced(self) -> bool:
        """Whether the joint was locked and moved."""
        return self.moved and not self.free

    @property
    def against(self) -> bool:
        """Whether the attempt broke the rules."""
        return self.free != self.moved or self.other


@dataclass(frozen=True, slots=True, kw_only=True)
class BreakShares:
    """How often the plant broke the rules of the box, each share with an interval clustered by trial.

    Attributes:
        missed: Of the attempts at free joints, those that moved nothing.
        forced: Of the attempts at locked joints, those that moved them.
        others: Of all attempts, those after which another joint had changed its position.
    """

    missed: ClusteredProportion
    forced: ClusteredProportion
    others: ClusteredProportion


def break_shares(trials: Sequence[Trial], box: Lockbox) -> BreakShares:
    """The shares of one agent under one condition; trials of people are clustered by person and luck."""
    found = [against_rules(trial, box) for trial in trials]
    player, luck = [trial.player for trial in trials], [f"{trial.repetition}/{trial.trial}" for trial in trials]

    def share(happened: Sequence[int], of: Sequence[int]) -> ClusteredProportion:
        return crossed_proportion(happened, of, player, luck) if any(player) else clustered_proportion(happened, of)

    free = [sum(one.free for one in judged) for judged in found]
    every = [len(judged) for judged in found]
    return BreakShares(
        missed=share([sum(one.missed for one in judged) for judged in found], free),
        forced=share(
            [sum(one.forced for one in judged) for judged in found],
            [of - those for of, those in zip(every, free, strict=True)],
        ),
        others=share([sum(one.other for one in judged) for judged in found], every),
    )


def unbroken(trial: Trial, box: Lockbox) -> int:
    """The number of attempts of a trial before the first one that broke the rules; all if none did."""
    return next((i for i, one in enumerate(against_rules(trial, box)) if one.against), len(trial.steps))


def against_rules(trial: Trial, box: Lockbox) -> list[Judged]:
    """Every attempt of a trial before the rules of its box; none if the trial is of other joints.

    Whether another joint changed is known from the state before the next attempt.
    """
    if sorted(trial.joints) != sorted(box.names):
        return []
    order = tuple(trial.joints.index(name) for name in box.names)
    judged = []
    for step, after in zip_longest(trial.steps, trial.steps[1:]):
        place = trial.joints.index(step.joint)
        other = after is not None and (
            step.state[:place] != after.state[:place] or step.state[place + 1 :] != after.state[place + 1 :]
        )
        free = box.may_move(tuple(step.state[at] == "1" for at in order), box.names.index(step.joint))
        judged.append(Judged(free, step.moved, other))
    return judged
