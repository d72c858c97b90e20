"""The effect of one report, from forks of recorded trials.

A fork replays a recorded trial up to one report, changes that report, and lets the agent play on. Arms share the past
and, if the agent is seeded, the luck of the future. So the difference between two arms is the effect of that report
alone. Forks also measure the first lie in a truthful world, which the records of a study cannot give.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import trial_stream
from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, block_mean
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.holm import holm
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


@dataclass(frozen=True, slots=True, kw_only=True)
class BranchEffect:
    """The effect of an arm at one fork point of one agent's trials, compared with a true report.

    Attributes:
        agent: Its name, or its spec if it has none.
        condition: The condition of the forked trials, as their keys name it.
        where: The fork point: a step's number, or a rule (:data:`RULES`).
        arm: Name of the arm.
        truthful: Whether all later reports are true.
        outcome: The outcome that is compared.
        after_truth: Mean outcome after a true report.
        change: Mean change of the outcome over trials; the continuations of a trial form a cluster. P values and
            intervals are corrected for the agents that are judged together (Bonferroni), P values of changes of success
            also for all of one agent (Holm).
        forks: Continuations compared.
        agents: Number of agents that are judged together.
    """

    agent: str
    condition: str
    where: str
    arm: str
    truthful: bool
    outcome: BranchOutcome
    after_truth: float
    change: BlockMean
    forks: int
    agents: int = 1


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
    """The steps after whose reports a rule forks a trial. The trial must have gone on after them.

    Raises:
        BadValue: As :func:`check_rule`.
    """
    check_rule(rule)
    last = len(trial.steps) - 1
    if rule == "every":
        return tuple(range(1, last + 1))
    found = _STEP_OF_RULE[rule](trial) if rule in _STEP_OF_RULE else int(rule)
    return (found,) if 1 <= found <= last else ()


def _first_lie(trial: Trial) -> int:
    """The step with the first false report; 0 without one."""
    return next((n for n, false in enumerate(false_reports(trial), 1) if false), 0)


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
    "first-lie": _first_lie,
    "before-onset": _before_onset,
}


def branch_effects(
    forks: Sequence[Trial],
    parents: Mapping[str, Trial],
    rules: Sequence[str] | None = None,
    chances: Chances | None = None,
) -> list[BranchEffect]:
    """The effect of every arm at every fork point, compared with a true report there.

    Args:
        forks: The records of the forks; those that ended as error are left out.
        parents: Key -> recorded trial.
        rules: Places as they were asked for, ``every`` for each step apart. If not given, every step and rule, for
            arms in which all trials are forked there that are forked anywhere and go on there.
        chances: Key of a fork -> probabilities of its next choice, where they are known and not on record.

    Returns:
        By agent, condition, fork point, arm and outcome; fork points with a single trial are left out.
    """
    known, budget = chances or {}, max((fork.budget for fork in forks), default=0)
    placed: dict[tuple[str, str, bool], dict[tuple[str, int], dict[str, dict[int, Trial]]]] = {}
    for fork in forks:
        name = fork.fork
        if name is None or fork.ending == "error" or (parent := parents.get(name.parent)) is None:
            continue
        cell = placed.setdefault((parent.group, parent.condition, name.truthful), {})
        cell.setdefault((name.parent, name.at), {}).setdefault(name.arm, {})[name.time] = fork
    baseline = {trial.group: is_baseline(trial.spec) for trial in parents.values()}
    found, sizes = [], Counter(baseline[agent] for agent in {agent for agent, *_ in placed})
    for (agent, condition, truthful), there in placed.items():
        agents = sizes[baseline[agent]]
        for where, points in _by_place(there, parents, rules).items():
            for arm in dict.fromkeys(arm for at in there.values() for arm in at if arm != TRUTH):
                forked = [point for point in points if arm in there.get(point, ())]
                if rules is None and len(forked) < len(points):
                    continue
                for outcome in get_args(BranchOutcome):
                    rows = [_row(there[point], parents[point[0]], point[1], arm, outcome, known) for point in forked]
                    if one := _effect([row for row in rows if row is not None], outcome, budget, agents):
                        effect = BranchEffect(
                            agent=agent,
                            condition=condition,
                            where=where,
                            arm=arm,
                            truthful=truthful,
                            outcome=outcome,
                            after_truth=one[0],
                            change=one[1],
                            forks=one[2],
                            agents=agents,
                        )
                        found.append(effect)
    return _corrected(found)


def _corrected(effects: Sequence[BranchEffect]) -> list[BranchEffect]:
    """The effects with P values of success corrected for all effects on one agent (Holm)."""
    found = list(effects)
    for agent in {one.agent for one in effects}:
        places = [i for i, one in enumerate(found) if (one.agent, one.outcome) == (agent, "solved")]
        values = holm([found[i].change.p_value for i in places])
        for i, value in zip(places, values, strict=True):
            found[i] = replace(found[i], change=replace(found[i].change, p_value=value))
    return found


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
    arms: Mapping[str, Mapping[int, Trial]],
    parent: Trial,
    at: int,
    arm: str,
    outcome: BranchOutcome,
    chances: Chances,
) -> tuple[Array, Array] | None:
    """Outcomes of an arm and of a true report, one pair per continuation; None if either is missing.

    If continuations share no luck, one true report may serve several pairs: it is the recorded trial.
    """
    told, changed = arms.get(TRUTH), arms.get(arm)
    if not told or not changed:
        return None
    if outcome == "choice":  # known before anything else is attempted next
        return _moved_chances(next(iter(told.values())), next(iter(changed.values())), at, chances)
    base = {time: _outcome(fork, parent, at, outcome) for time, fork in told.items()}
    only = next(iter(base.values())) if len(base) == 1 else math.nan
    pairs = [(_outcome(fork, parent, at, outcome), base.get(time, only)) for time, fork in changed.items()]
    kept = [(one, other) for one, other in pairs if not math.isnan(one + other)]
    return (np.array([one for one, _ in kept]), np.array([other for _, other in kept])) if kept else None


def _moved_chances(told: Trial, changed: Trial, at: int, chances: Chances) -> tuple[Array, Array] | None:
    """The distance of the next choice's probabilities from those after a true report; None if they are not known."""
    there = [fork.steps[at].decision.probabilities or chances.get(fork.key) for fork in (told, changed)]
    if there[0] is None or there[1] is None:
        return None
    apart = sum(abs(one - other) for one, other in zip(there[0], there[1], strict=True)) / 2
    return np.array([apart]), np.zeros(1)


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
) -> tuple[float, BlockMean, int] | None:
    """Mean after a true report, change, and number of pairs, from one row per trial."""
    if len(rows) < 2:
        return None
    widest = max(len(changed) for changed, _ in rows)
    differences = np.full((len(rows), widest), np.nan)
    for row, (changed, told) in zip(differences, rows, strict=True):
        row[: len(changed)] = changed - told
    told = np.concatenate([told for _, told in rows])
    if outcome == "steps":
        changed = np.concatenate([changed for changed, _ in rows])
        shortest = float(min(told.min(), changed.min()))
        rare = rare_block(float(told.mean()), float(changed.mean()), budget, shortest)
        change = block_mean(differences, unit=float(budget), choices=agents, rare=rare)
    else:
        change = block_mean(differences, unit=None if outcome == "choice" else 1.0, choices=agents)
    p_value = None if change.p_value is None else min(1.0, agents * change.p_value)
    if outcome == "choice":  # no test: that chances differ is known
        p_value = None
    change = replace(change, p_value=p_value)
    return float(told.mean()), change, len(told)
