"""Optimal actions: each action judged by an ideal observer who was told the same as the agent and believes it.

An action is *optimal* if no other costs fewer expected steps under a stated prior
(:mod:`lockprobe.boxes.beliefs`). At p = 0 the observer is right to believe reports.

Pictures are judged as if read without error: a picture counts as a report of positions (``symbolic?tell=state``), and
a misreading counts against the agent.

No interlock explains an attempt that broke the rules of the box: a hand that missed, or forced a locked joint. What the
agent is told of it misleads every observer. So of each trial the actions before the first such attempt are judged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from lockprobe.boxes.beliefs import NEVER, Interlocks, as_mask, interlocks
from lockprobe.boxes.planning import SAME, planner
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Proportion
from lockprobe.statistics.rules import Judged, state_after, unbroken
from lockprobe.trial.record import Trial

JUDGED, ACTIONS = 100, 5000
"""The most trials of a condition that are judged, the first by repetition and trial; and the actions after which no
further trial is judged."""


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
    chosen, contradicted, actions = list[list[bool]](), False, 0
    for trial in counted[:JUDGED]:
        if actions < ACTIONS:
            own, again = _choices(trial, prior, unbroken(trial, judged(trial) if judged else ()))
            chosen.append(own)
            contradicted |= again
            actions += len(trial.steps)
    share = clustered_proportion([*map(sum, chosen)], [*map(len, chosen)])
    return (share, contradicted) if share.n else None


def _choices(trial: Trial, prior: str, first: int) -> tuple[list[bool], bool]:
    """Whether each of the first actions is optimal; whether a report was impossible.

    The target is joint 0, the others follow in the order of first attempts. The priors treat all joints but the target
    alike, so trials that differ only in names share what was planned.
    """
    numbers = {joint: i for i, joint in enumerate(dict.fromkeys((trial.target, *trial.actions, *trial.joints)))}
    bits, known = [1 << numbers[joint] for joint in trial.joints], interlocks(prior, len(trial.joints))
    now, found, contradicted, states_only = (_solvable(known, 0), 0), list[bool](), False, trial.states_only
    for step in trial.steps[:first]:
        joint = numbers[step.joint]
        found.append(_optimal(known, now)[joint])
        if trial.solved and step is trial.steps[-1]:
            break
        seen = state_after(trial, step) if step.pictures and step.told_state is None else step.told_state
        told = None
        if seen is not None:
            told = sum(bit for bit, at, was in zip(bits, seen, trial.steps[0].state, strict=True) if at != was)
        now, again = _after(known, now, joint, bool(step.told_moved), told, states_only)
        contradicted |= again
    return found, contradicted


_Known = tuple[int, int]
"""What an observer that believes every report knows: the interlocks that are possible, bit s for interlock s, and the
configuration."""


@cache
def _solvable(known: Interlocks, configuration: int) -> int:
    """The interlocks under which the box can be solved from a configuration."""
    return as_mask(known.distance[:, configuration] < NEVER)


@cache
def _optimal(known: Interlocks, now: _Known) -> list[bool]:
    """Whether no other attempt costs fewer expected steps than that at each joint."""
    steps = planner(known).values(*now)
    return [one <= min(steps) + SAME for one in steps]


def _after(
    known: Interlocks, now: _Known, joint: int, moved: bool, told: int | None, states_only: bool
) -> tuple[_Known, bool]:
    """What is known after a report, given that the trial goes on, and whether the report was impossible.

    It is :func:`lockprobe.boxes.beliefs.update` for an observer that believes every report. Of what is
    impossible it keeps the report alone, at the configuration before it, or else at that after it.
    """

    def believed(now: _Known) -> _Known | None:
        (possible, at), bit = now, 1 << joint
        said = moved
        if told is not None:
            said = bool((at ^ told) & bit) if states_only else moved
            if (at ^ told ^ said * bit) & ~1:  # the target is at rest, whatever is told of it
                return None
        free = known.masks[at][joint]
        possible &= free if said else ~free
        if (not joint and said) or not possible:
            return None
        return possible, at ^ said * bit

    if (found := believed(now)) is not None:
        return found, False
    before = (now[1] if told is None else told ^ moved << joint) & ~1
    if (found := believed((_solvable(known, before), before))) is not None:
        return found, True
    at = (before ^ moved << joint) & ~1
    possible = _solvable(known, at)
    return (possible if joint else possible & ~known.masks[at][0] or possible, at), True
