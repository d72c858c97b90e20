"""Optimal actions: each action judged by an ideal observer who was told the same as the agent and believes it.

An action is *optimal* if no other costs fewer expected steps under a stated prior
(:mod:`lockprobe.boxes.beliefs.structures`). At p = 0 the observer is right to believe reports.

Pictures are judged as if read without error: a picture counts as a report of positions (``symbolic?tell=state``), and
a misreading counts against the agent.

No interlock explains an attempt that broke the rules of the box: a hand that missed, or forced a locked joint. What the
agent is told of it misleads every observer. So of each trial the actions before the first such attempt are judged.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cache, cached_property

from lockprobe.boxes.beliefs.planning import best_joints
from lockprobe.boxes.beliefs.posterior import Belief, ReportedAttempt, begin, noise_model, update
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.rules import Judged, state_after, unbroken
from lockprobe.trial.record import Trial

JUDGED, ACTIONS = 100, 5000
"""The most trials of a condition that are judged, the first by repetition and trial; and the actions after which no
further trial is judged."""

_MANY = 1 << 14
"""Moments that are cached; each takes a few kilobytes."""


def prior_for(joints: int) -> str | None:
    """The prior of the report: ``single-parent`` up to 4 joints, ``chains`` for 5 and 6; None for more."""
    return "single-parent" if joints <= 4 else "chains" if joints <= 6 else None


def optimal_actions(
    trials: Sequence[Trial], judged: Callable[[Trial], Sequence[Judged]] | None = None
) -> tuple[Proportion, bool] | None:
    """The share of optimal actions under one condition, and whether reports were impossible under the prior.

    None if no action can be judged: none was played, the box is too large for a prior, or in some trials an action was
    not the choice or a report was missing (the others would be no fair sample). ``judged`` says how the
    attempts of a trial stand before the rules of its box, where some broke them.
    """
    counted = [trial for trial in ended(trials) if trial.steps]
    prior = prior_for(max((len(trial.joints) for trial in counted), default=0))
    steps = [step for trial in counted for step in trial.steps]
    if prior is None or any(step.chosen is not None or step.told_moved is None for step in steps):
        return None
    chosen, contradicted, actions = list[list[tuple[_Moment, int]]](), False, 0
    for trial in counted[:JUDGED]:
        if actions < ACTIONS:
            own, again = _choices(trial, prior, unbroken(trial, judged(trial) if judged else ()))
            chosen.append(own)
            contradicted |= again
            actions += len(trial.steps)
    counts = [sum(now.optimal[joint] for now, joint in own) for own in chosen]
    share = clustered_proportion(counts, [*map(len, chosen)])
    return (share, contradicted) if share.n else None


class _Moment:
    """A belief of the observer and those that follow it, each computed once: many trials pass through equal beliefs.

    Attributes:
        after: Joint, whether it was told to move, joints turned, states only -> the moment after such a report, and
            whether it was impossible; as they come.
    """

    def __init__(self, belief: Belief) -> None:
        self.belief = belief
        self.after: dict[tuple[int, bool, int | None, bool], tuple[_Moment, bool]] = {}

    @cached_property
    def optimal(self) -> list[bool]:
        """Whether no other attempt costs fewer expected steps than that at each joint."""
        found: list[bool] = best_joints(self.belief).tolist()
        return found


_known: dict[Hashable, _Moment] = {}


def _moment(belief: Belief) -> _Moment:
    """The moment of a belief, the same object for equal beliefs; all are forgotten where they become too many."""
    if len(_known) >= _MANY:
        _known.clear()
    return _known.setdefault(belief.key, _Moment(belief))


@cache
def _first(prior: str, joints: int) -> _Moment:
    """The moment before any report."""
    return _Moment(begin(interlocks(prior, joints), noise_model("naive")))


def _choices(trial: Trial, prior: str, first: int) -> tuple[list[tuple[_Moment, int]], bool]:
    """The first actions, by the moment before each and the number of its joint; whether a report was impossible.

    The target is joint 0, the others follow in the order of first attempts. The priors treat all joints but the target
    alike, so trials that differ only in names share moments.
    """
    numbers = {joint: i for i, joint in enumerate(dict.fromkeys((trial.target, *trial.actions, *trial.joints)))}
    bits = [1 << numbers[joint] for joint in trial.joints]
    now = _first(prior, len(trial.joints))
    found, contradicted, start, states_only = [], False, trial.steps[0].state, trial.states_only
    for step in trial.steps[:first]:
        joint = numbers[step.joint]
        found.append((now, joint))
        if trial.solved and step is trial.steps[-1]:
            break
        seen = state_after(trial, step) if step.pictures and step.told_state is None else step.told_state
        turned = None
        if seen is not None:
            turned = sum(bit for bit, at, was in zip(bits, seen, start, strict=True) if at != was)
        report = joint, bool(step.told_moved), turned, states_only
        if report not in now.after:
            belief = update(now.belief, ReportedAttempt(*report))
            again = belief.restarts > now.belief.restarts
            scaled = again and joint == 0  # scaled weights of equal beliefs differ in their last digits
            now.after[report] = (_Moment if scaled else _moment)(belief), again
        now, again = now.after[report]
        contradicted |= again
    return found, contradicted
