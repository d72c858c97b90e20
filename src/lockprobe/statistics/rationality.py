"""Rationality of actions: each step judged by an ideal observer who was told the same as the agent.

Two observers judge, both under a stated prior (:mod:`lockprobe.boxes.beliefs.structures`):

* ``naive`` believes every report. Its expected steps are exact. At p = 0 it is right.
* ``aware`` infers how often reports are false and whether false positions stay. Its expected steps are QMDP's, which
  assume full knowledge after the next attempt: lower bounds that give no credit for information.

Pictures are judged as if read without error: a picture counts as a report of positions (``symbolic?tell=state``), and
a misreading counts against the agent.

No interlock explains an attempt that broke the rules of the box: a hand that missed, or forced a locked joint. What the
agent is told of it misleads every observer. So of each trial the actions before the first such attempt are judged, and
how many are left out is counted.

An action is *optimal* if no other costs fewer expected steps; its *regret* is its extra cost, in steps that the
observer expects under its prior, not on the box that was played. Each share is compared with that of a uniformly
random choice in the same situations, which is often optimal where several joints are equally good.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from statistics import fmean

import numpy as np

from lockprobe.boxes.beliefs.posterior import KnownReading, ReportedAttempt, begin, noise_model
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.clustered import ClusteredMean, ClusteredProportion, cluster_bootstrap, clustered_proportion
from lockprobe.statistics.judged_moments import JudgedMoment, moment, weigh
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.rules import unbroken
from lockprobe.trial.record import Trial

__all__ = [
    "ACTIONS",
    "JUDGED",
    "OBSERVERS",
    "JudgedStep",
    "JudgedTrial",
    "Rationality",
    "judge",
    "prior_for",
    "rationality",
]

OBSERVERS = ("naive", "aware")
"""The noise models of the judging observers."""

JUDGED, ACTIONS = 100, 5000
"""The most trials of a condition that are judged, the first by repetition and trial; and the actions after which no
further trial is judged."""

Told = tuple[int, ReportedAttempt | None]
"""The number of the joint attempted, and its report; None if the box opened."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedStep:
    """One judged action, compared with a uniformly random choice in the same situation.

    Attributes:
        step: From 1.
        entropy: The observer's entropy over interlocks before the step, in bits.
        gained: Bits by which the step reduced it; below 0 if the report confused the observer.
        expected: Expected information of the action, bits.
        best: Expected information of the most informative action, bits.
        optimal: Whether no other action costs fewer expected steps.
        regret: Expected steps more than those of the best action, >= 0.
        uninformative: Whether it could neither give information nor open the box.
        by_chance: Means of ``expected``, ``optimal``, ``regret`` and ``uninformative`` of the random choice.
    """

    step: int
    entropy: float
    gained: float
    expected: float
    best: float
    optimal: bool
    regret: float
    uninformative: bool
    by_chance: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedTrial:
    """The judged actions of one trial.

    Attributes:
        key: Its readable name.
        prior: Name of the prior.
        noise: Noise model of the observer.
        steps: The actions.
        entropy_left: The observer's entropy over interlocks after the last report, bits.
        restarts: Reports that were impossible to the observer, so that it began again.
    """

    key: str
    prior: str
    noise: str
    steps: tuple[JudgedStep, ...]
    entropy_left: float
    restarts: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Rationality:
    """The rationality of one condition's actions, judged by one observer. Shares and means are over all actions.

    Intervals take the trial as a cluster. Error trials are left out.

    Attributes:
        prior: Name of the prior.
        interlocks: Number of its interlocks.
        noise: Noise model of the observer.
        trials: Trials judged.
        steps: Actions judged.
        not_judged: Trials that ended but lie beyond :data:`JUDGED` or :data:`ACTIONS`.
        left_out: Actions of these trials that are not judged: attempts that broke the rules of the box, and all later
            ones.
        optimal: Share of optimal actions.
        regret: Mean regret in expected steps.
        uninformative: Share of actions that could neither give information nor open the box.
        gained, expected, best: Means of these fields of :class:`JudgedStep`, bits.
        by_chance: ``optimal``, ``regret``, ``uninformative`` and ``expected`` of a random choice.
        entropy_left: Mean entropy after the last judged action of a trial, bits.
        restarts: Mean restarts per trial.
    """

    prior: str
    interlocks: int
    noise: str
    trials: int
    steps: int
    not_judged: int
    left_out: int
    optimal: ClusteredProportion
    regret: ClusteredMean
    uninformative: ClusteredProportion
    gained: float
    expected: float
    best: float
    by_chance: Mapping[str, float]
    entropy_left: float
    restarts: float


def prior_for(joints: int) -> str | None:
    """The prior of the report: ``single-parent`` up to 4 joints, ``chains`` for 5 and 6; None for more."""
    return "single-parent" if joints <= 4 else "chains" if joints <= 6 else None


def rationality(trials: Sequence[Trial], box: Lockbox | None = None) -> tuple[Rationality, ...]:
    """Judge the trials of one condition.

    Empty if none has ended with an action that can be judged, if the box is too large for a prior, or if in some of
    them an action was not the choice or a report was missing: the others are those in which that did not happen, which
    is no fair sample.

    Args:
        trials: The trials.
        box: Their box, whose rules the plant may have broken; None if it is not known.
    """
    counted = [trial for trial in ended(trials) if trial.steps]
    if not all(trial.ordinary for trial in counted):
        return ()
    prior, first = prior_for(len(counted[0].joints)) if counted else None, _first(counted)
    told = [(trial, _told(trial)[: unbroken(trial, box) if box else None]) for trial in first]
    if prior is None or not any(reports for _, reports in told):
        return ()
    return tuple(_condition(counted, told, prior, noise) for noise in OBSERVERS)


def _condition(
    trials: Sequence[Trial], told: Sequence[tuple[Trial, Sequence[Told]]], prior: str, noise: str
) -> Rationality:
    found = [_seen(trial, reports, prior, noise) for trial, reports in told if reports]
    weigh(now for one in found for now in one.moments[:-1])
    sizes = [len(one.joints) for one in found]
    first, cluster = trials[0], np.repeat(np.arange(len(found)), sizes)
    acting = " + ".join(first.specs)
    rng = generator(first.seed, "analysis", first.spec, first.modality, acting, "rationality", noise)
    worths = [(now.worth, joint) for one in found for now, joint in one.choices]

    def share(chosen: Iterable[bool]) -> ClusteredProportion:
        return clustered_proportion(np.bincount(cluster, np.fromiter(chosen, dtype=np.float64)), sizes)

    return Rationality(
        prior=prior,
        interlocks=len(interlocks(prior, len(first.joints))),
        noise=noise,
        trials=len(found),
        steps=len(worths),
        not_judged=len(trials) - len(told),
        left_out=sum(len(trial.steps) - len(reports) for trial, reports in told),
        optimal=share(worth.optimal[joint] for worth, joint in worths),
        regret=cluster_bootstrap([worth.regret[joint] for worth, joint in worths], cluster, rng),
        uninformative=share(worth.uninformative[joint] for worth, joint in worths),
        gained=fmean([bits for one in found for bits in one.gained]),
        expected=fmean([worth.bits[joint] for worth, joint in worths]),
        best=fmean([worth.best for worth, _ in worths]),
        by_chance={name: fmean([worth.by_chance[name] for worth, _ in worths]) for name in worths[0][0].by_chance},
        entropy_left=fmean([one.moments[-1].entropy for one in found]),
        restarts=fmean([one.restarts for one in found]),
    )


def _first(trials: Sequence[Trial]) -> Sequence[Trial]:
    """The trials that are judged."""
    before = accumulate((len(trial.steps) for trial in trials[:JUDGED]), initial=0)
    return [trial for trial, actions in zip(trials[:JUDGED], before, strict=False) if actions < ACTIONS]


def judge(trial: Trial, *, prior: str, noise: str = "naive") -> JudgedTrial:
    """Judge every action of a trial, of any agent, by an ideal observer who was told the same.

    Args:
        trial: With at least one step.
        prior: Name of the prior.
        noise: ``naive``, ``aware`` or a flip probability.

    Raises:
        UnknownName: If there is no such prior.
        BadValue: If there is no such noise model, or the prior has too many interlocks over this number of joints.
    """
    seen = _seen(trial, _told(trial), prior, noise)
    weigh(seen.moments[:-1])
    steps = [
        JudgedStep(
            step=step.step,
            entropy=now.entropy,
            gained=gained,
            expected=now.worth.bits[joint],
            best=now.worth.best,
            optimal=now.worth.optimal[joint],
            regret=now.worth.regret[joint],
            uninformative=now.worth.uninformative[joint],
            by_chance=now.worth.by_chance,
        )
        for step, (now, joint), gained in zip(trial.steps, seen.choices, seen.gained, strict=True)
    ]
    return JudgedTrial(
        key=trial.key,
        prior=prior,
        noise=noise,
        steps=tuple(steps),
        entropy_left=seen.moments[-1].entropy,
        restarts=seen.restarts,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _SeenTrial:
    """A trial as an observer saw it.

    Attributes:
        joints: The number of the joint of every action.
        moments: The moment before every action, and that after the last one.
        restarts: Reports that were impossible to the observer.
    """

    joints: tuple[int, ...]
    moments: tuple[JudgedMoment, ...]
    restarts: int

    @property
    def choices(self) -> Iterator[tuple[JudgedMoment, int]]:
        """Every action, with the moment before it."""
        return zip(self.moments, self.joints, strict=False)

    @property
    def gained(self) -> list[float]:
        """Bits by which every action reduced the entropy."""
        return [before.entropy - after.entropy for before, after in pairwise(self.moments)]


def _seen(trial: Trial, told: Sequence[Told], prior: str, noise: str) -> _SeenTrial:
    """The actions of a trial that were told, which may be the first ones alone."""
    now = moment(begin(interlocks(prior, len(trial.joints)), noise_model(noise, _reading(trial))))
    moments, restarts = [now], 0
    for _, report in told:
        now, again = now.after(report)
        moments.append(now)
        restarts += again
    return _SeenTrial(joints=tuple(joint for joint, _ in told), moments=tuple(moments), restarts=restarts)


def _reading(trial: Trial) -> KnownReading:
    """What the observer knows to be inverted: what was inverted in this trial, or outcomes."""
    return "positions" if any(channel.get("inverts") == "position" for channel in trial.channels) else "outcomes"


def _told(trial: Trial) -> list[Told]:
    """Every attempt and its report, with joints as numbers."""
    numbers, shown, states_only = _numbers(trial), _shown(trial), trial.states_only
    positions = {told: _positions(trial, numbers, told) for told in set(shown)}
    found: list[Told] = [
        (
            joint := numbers[step.joint],
            ReportedAttempt(joint, bool(step.told_moved), positions[told], states_only),
        )
        for step, told in zip(trial.steps, shown, strict=True)
    ]
    return [*found[:-1], (found[-1][0], None)] if trial.solved else found


def _shown(trial: Trial) -> list[str | None]:
    """The configuration as told or pictured after every step, a bit string in panel order; None if neither."""
    last = trial.steps[-1]
    moved = {trial.joints.index(last.joint)} if last.moved else set()
    ended = "".join(str(int(bit) ^ (i in moved)) for i, bit in enumerate(last.state))
    after = [*(step.state for step in trial.steps[1:]), ended]
    return [
        true if step.pictures and step.told_state is None else step.told_state
        for step, true in zip(trial.steps, after, strict=True)
    ]


def _numbers(trial: Trial) -> dict[str, int]:
    """The number of every joint: the target is 0, the others follow in the order of first attempts.

    The priors treat all joints but the target alike, so trials that differ only in names share cache entries.
    """
    order = dict.fromkeys((trial.target, *trial.actions, *trial.joints))
    return {joint: number for number, joint in enumerate(order)}


def _positions(trial: Trial, numbers: Mapping[str, int], told: str | None) -> int | None:
    """The joints reported away from their start, as bits."""
    if told is None:
        return None
    pairs = zip(trial.joints, told, trial.steps[0].state, strict=True)
    return sum((now != start) << numbers[joint] for joint, now, start in pairs)
