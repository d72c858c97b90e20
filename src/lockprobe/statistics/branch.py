"""The effect of one report, from forks of recorded trials.

A fork replays a recorded trial up to one report, changes that report, and lets the agent play on. Arms share the past
and, if the agent is seeded, the luck of the future. So the difference between two arms is the effect of that report
alone. Forks also measure the first lie in a truthful world, which the records of a study cannot give.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, get_args

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import trial_stream
from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, block_mean
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.holm import holm
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.rare_long_trials import rare_block
from lockprobe.trial.record import Trial
from lockprobe.trial.told_outcome import false_reports

RULES = ("onset", "first-lie", "before-onset", "every")
"""Where a trial can be forked, in addition to a step's number: at the report that completes its first loop; at its
first false report; at one step drawn from 3 up to its first loop, or to its end; after every step."""

TRUTH = "truth"
"""The arm with which others are compared."""

BranchOutcome = Literal["solved", "steps", "leaves", "repeats", "choice"]
"""The box is solved; steps that the whole trial takes, its budget where it is not solved; the next action is not the
one that continues the loop (in a loop alone); the next action repeats that of the fork; how far the probabilities of
the next choice are from those after a true report (total variation, 0 if they are equal, at most 1), not sampled."""

Chances = Mapping[str, Sequence[float]]
"""Key of a fork -> the exact probabilities of its next choice, by joint."""

_LOOP = 3
"""Actions that are in a loop if they have stood in this order before, without overlap."""

_EARLIEST = 3
"""The first step that ``before-onset`` draws."""


class Fork(NamedTuple):
    """What an effect is of: one agent's trials of a condition, where they were forked, and what was changed there."""

    agent: str
    condition: str
    where: str
    arm: str
    truthful: bool
    """Whether all later reports are true."""
    outcome: BranchOutcome


Effects = dict[Fork, tuple[float, BlockMean, int]]
"""What :func:`branch_effects` returns."""


def continuation(actions: tuple[str, ...]) -> str | None:
    """The action that continues a loop: what followed the latest earlier copy of the last three; None without one."""
    last = actions[-_LOOP:]
    for start in range(len(actions) - 2 * _LOOP, -1, -1):
        if len(last) == _LOOP and actions[start : start + _LOOP] == last:
            return actions[start + _LOOP]
    return None


def check_rule(rule: str) -> None:
    """Refuse a rule that names no fork point.

    Raises:
        BadValue: If it is neither a step from 1 nor one of :data:`RULES`.
    """
    if rule not in RULES and not (rule.isdecimal() and int(rule) >= 1):
        raise BadValue("at", rule, f"a step from 1, or one of {', '.join(RULES)}")


def fork_steps(trial: Trial, rule: str) -> tuple[int, ...]:
    """The steps after whose reports a rule forks a trial, which must have gone on; refused as by :func:`check_rule`."""
    check_rule(rule)
    last = len(trial.steps) - 1
    if rule == "every":
        return tuple(range(1, last + 1))
    found = _STEP_OF_RULE[rule](trial) if rule in _STEP_OF_RULE else int(rule)
    return (found,) if 1 <= found <= last else ()


def _before_onset(trial: Trial) -> int:
    """A random step up to the first loop, or up to the end; 0 if the loop comes too early."""
    last = len(trial.steps) - 1
    end = min(_onset(trial) or last, last)
    draw = trial_stream(trial.seed, trial.repetition, trial.trial, "before-onset").random()
    return _EARLIEST + int(draw * (end - _EARLIEST + 1)) if end >= _EARLIEST else 0


def _onset(trial: Trial) -> int:
    """The step that completes the first loop; 0 without a loop."""
    actions = trial.actions
    return next((n for n in range(1, len(actions) + 1) if continuation(actions[:n]) is not None), 0)


_STEP_OF_RULE: Mapping[str, Callable[[Trial], int]] = {
    "onset": _onset,
    "first-lie": lambda trial: next((n for n, false in enumerate(false_reports(trial), 1) if false), 0),
    "before-onset": _before_onset,
}


def branch_effects(
    forks: Sequence[Trial],
    parents: Mapping[str, Trial],
    rules: Sequence[str] | None = None,
    chances: Chances | None = None,
) -> Effects:
    """The effect of every arm at every fork point, compared with a true report there.

    Args:
        forks: The records of the forks; those that ended as error are left out.
        parents: Key -> recorded trial.
        rules: Places as they were asked for, ``every`` for each step apart. If not given, every step and rule, for
            arms in which all trials are forked there that are forked anywhere and go on there.
        chances: Key of a fork -> probabilities of its next choice, where they are known and not on record.

    Returns:
        The mean outcome after a true report; its mean change over trials, whose continuations form a cluster; and the
        number of agents judged together, for which both are corrected (Bonferroni), P values of success also for all
        of one agent (Holm). Fork points with a single trial are left out.
    """
    known, budget = chances or {}, max((fork.budget for fork in forks), default=0)
    placed: dict[tuple[str, str, bool], dict[tuple[str, int], dict[str, dict[int, Trial]]]] = {}
    for fork in ended(forks):
        if (name := fork.fork) and (parent := parents.get(name.parent)):
            cell = placed.setdefault((parent.group, parent.condition, name.truthful), {})
            cell.setdefault((name.parent, name.at), {}).setdefault(name.arm, {})[name.time] = fork
    baseline = {trial.group: is_baseline(trial.spec) for trial in parents.values()}
    found, sizes = Effects(), Counter(baseline[agent] for agent in {agent for agent, *_ in placed})
    for (agent, condition, truthful), there in placed.items():
        agents = sizes[baseline[agent]]
        for where, points in _by_place(there, parents, rules).items():
            for arm in dict.fromkeys(arm for at in there.values() for arm in at if arm != TRUTH):
                forked = [point for point in points if arm in there.get(point, ())]
                if len(forked) < (len(points) if rules is None else 2):
                    continue
                for outcome in get_args(BranchOutcome):
                    rows = [_row(there[point], parents[point[0]], point[1], arm, outcome, known) for point in forked]
                    if one := _effect([row for row in rows if row is not None], outcome, budget, agents):
                        found[Fork(agent, condition, where, arm, truthful, outcome)] = (*one, agents)
    return found | _corrected(found)


def _corrected(found: Effects) -> Effects:
    """Those on success, with P values corrected for all of one agent (Holm)."""
    made = {}
    for agent in {one.agent for one in found}:
        family = [one for one in found if (one.agent, one.outcome) == (agent, "solved")]
        for one, value in zip(family, holm([found[one][1].p_value for one in family]), strict=True):
            after, change, agents = found[one]
            made[one] = after, replace(change, p_value=value), agents
    return made


def _by_place(
    there: Mapping[tuple[str, int], object], parents: Mapping[str, Trial], rules: Sequence[str] | None
) -> dict[str, list[tuple[str, int]]]:
    """Fork point -> the trials and steps at it, among all forked trials."""
    steps = [str(at) for at in sorted({at for _, at in there})]
    asked = [*steps, *(rule for rule in RULES if rule != "every")] if rules is None else rules
    named = dict.fromkeys(one for rule in asked for one in (steps if rule == "every" else [rule]))
    keys = dict.fromkeys(key for key, _ in there)
    return {rule: [(key, at) for key in keys for at in fork_steps(parents[key], rule)] for rule in named}


def _row(
    arms: Mapping[str, Mapping[int, Trial]], parent: Trial, at: int, arm: str, outcome: BranchOutcome, chances: Chances
) -> tuple[Array, Array] | None:
    """Outcomes of an arm and of a true report, one pair per continuation; None if either is missing.

    If continuations share no luck, one true report may serve several pairs: it is the recorded trial.
    """
    told, changed = arms.get(TRUTH), arms.get(arm)
    if not told or not changed:
        return None
    if outcome == "choice":  # known before anything else is attempted next
        both = [next(iter(one.values())) for one in (told, changed)]
        one, other = (fork.steps[at].decision.probabilities or chances.get(fork.key) for fork in both)
        if one is None or other is None:
            return None
        return np.array([sum(abs(a - b) for a, b in zip(one, other, strict=True)) / 2]), np.zeros(1)
    base = {time: _outcome(fork, parent, at, outcome) for time, fork in told.items()}
    only = next(iter(base.values())) if len(base) == 1 else math.nan
    pairs = np.array([(_outcome(fork, parent, at, outcome), base.get(time, only)) for time, fork in changed.items()])
    kept = pairs[~np.isnan(pairs).any(axis=1)]
    return (kept[:, 0], kept[:, 1]) if len(kept) else None


def _outcome(fork: Trial, parent: Trial, at: int, outcome: BranchOutcome) -> float:
    if outcome == "solved":
        return float(fork.solved)
    if outcome == "steps":
        return float(len(fork.steps) if fork.solved else fork.budget)
    following = fork.steps[at].joint
    if outcome == "repeats":
        return float(following == parent.steps[at - 1].joint)
    on = continuation(parent.actions[:at])
    return math.nan if on is None else float(following != on)


def _effect(
    rows: Sequence[tuple[Array, Array]], outcome: BranchOutcome, budget: int, agents: int
) -> tuple[float, BlockMean] | None:
    """The mean after a true report, and the change, from one row per trial."""
    if len(rows) < 2:
        return None
    differences = np.full((len(rows), max(len(changed) for changed, _ in rows)), np.nan)
    for row, (one, other) in zip(differences, rows, strict=True):
        row[: len(one)] = one - other
    changed, told = (np.concatenate(own) for own in zip(*rows, strict=True))
    rare = None
    if outcome == "steps":
        shortest = float(min(told.min(), changed.min()))
        rare = rare_block(float(told.mean()), float(changed.mean()), budget, shortest)
    unit = {"steps": float(budget), "choice": None}.get(outcome, 1.0)
    change = block_mean(differences, unit=unit, choices=agents, rare=rare)
    untested = outcome == "choice" or change.p_value is None  # that chances differ is known
    return float(told.mean()), replace(change, p_value=None if untested else min(1.0, agents * (change.p_value or 0.0)))
