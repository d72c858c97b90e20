"""The effect of one report, from forks of recorded trials.

A fork replays a recorded trial up to one report, changes that report, and lets the agent play on. Arms share the past
and, if the agent is seeded, the luck of the future. So the difference between two arms is the effect of that report
alone. Forks also measure the first lie in a truthful world, which the records of a study cannot give.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.blocks import Array, mean_of_blocks, rare_block
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.distributions import holm_by_family
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Difference
from lockprobe.trial.luck import Luck
from lockprobe.trial.record import Trial
from lockprobe.trial.source import false_reports

RULES = ("onset", "first-lie", "before-onset", "every")
"""Where a trial can be forked, in addition to a step's number: at the report that completes its first loop; at its
first false report; at one step drawn from 3 up to its first loop, or to its end; after every step."""

TRUTH = "truth"
"""The arm with which others are compared."""

OUTCOMES: Mapping[str, str] = {
    "success": "points",
    "steps": "steps",
    "leaves loop": "points",
    "repeats": "points",
}
"""Outcome -> the unit of its change. The box is solved; steps that the whole trial takes, its budget where it is not
solved; the next action is not the one that continues the loop (in a loop alone); the next action repeats that of the
fork."""

_LOOP = 3
"""Actions that are in a loop if they have stood in this order before, without overlap."""

_EARLIEST = 3
"""The first step that ``before-onset`` draws."""


class ForkEffect(NamedTuple):
    """What a changed report does to one agent's trials of a condition.

    Attributes:
        agent, condition: Whose trials, and under which condition.
        where: Where they were forked.
        arm: What was changed there.
        truthful: Whether all later reports are true.
        outcome: One of :data:`OUTCOMES`.
        after_truth: Its mean after a true report.
        change: Its mean change over trials, whose continuations form a cluster.
        agents: How many agents are judged together, for which the change is corrected (Bonferroni).
    """

    agent: str
    condition: str
    where: str
    arm: str
    truthful: bool
    outcome: str
    after_truth: float
    change: Difference
    agents: int


def continuation(actions: tuple[str, ...]) -> str | None:
    """The action that continues a loop: what followed the latest earlier copy of the last three; None without one."""
    last = actions[-_LOOP:]
    for start in range(len(actions) - 2 * _LOOP, -1, -1):
        if len(last) == _LOOP and actions[start : start + _LOOP] == last:
            return actions[start + _LOOP]
    return None


def check_rule(rule: str) -> None:
    """Refuse a rule that is neither a step from 1 nor one of :data:`RULES`."""
    if rule not in RULES and not (rule.isdecimal() and int(rule) >= 1):
        raise BadValue("at", rule, f"a step from 1, or one of {', '.join(RULES)}")


def fork_steps(trial: Trial, rule: str) -> tuple[int, ...]:
    """The steps after whose reports a rule forks a trial, which must have gone on; refused as by :func:`check_rule`."""
    check_rule(rule)
    last, actions = len(trial.steps) - 1, trial.actions
    if rule == "every":
        return tuple(range(1, last + 1))
    if rule == "first-lie":
        found = next((n for n, false in enumerate(false_reports(trial), 1) if false), 0)
    elif rule in RULES:
        found = next((n for n in range(1, last + 2) if continuation(actions[:n]) is not None), 0)
        if rule == "before-onset":  # up to the first loop, or to the end; nowhere if the loop comes too early
            end = min(found or last, last)
            luck = Luck(seed=trial.seed, box=trial.box, repetition=trial.repetition, trial=trial.trial)
            draw = luck.at(rule).random()
            found = _EARLIEST + int(draw * (end - _EARLIEST + 1)) if end >= _EARLIEST else 0
    else:
        found = int(rule)
    return (found,) if 1 <= found <= last else ()


def branch_effects(
    forks: Sequence[Trial],
    parents: Mapping[str, Trial],
    rules: Sequence[str] | None = None,
) -> list[ForkEffect]:
    """The effect of every arm at every fork point, compared with a true report there.

    P values of success are corrected for all of one agent, too (Holm). Fork points with a single trial are left out.

    Args:
        forks: The records of the forks; those that ended as error are left out.
        parents: Key -> recorded trial.
        rules: Places as they were asked for, ``every`` for each step apart. If not given, every step and rule, for
            arms in which all trials are forked there that are forked anywhere and go on there.
    """
    budget = max((fork.budget for fork in forks), default=0)
    placed: dict[tuple[str, str, bool], dict[tuple[str, int], dict[str, dict[int, Trial]]]] = {}
    for fork in ended(forks):
        if (name := fork.fork) and (parent := parents.get(name.parent)):
            cell = placed.setdefault((parent.group, parent.condition, name.truthful), {})
            cell.setdefault((name.parent, name.at), {}).setdefault(name.arm, {})[name.time] = fork
    baseline = {trial.group: is_baseline(trial.spec) for trial in parents.values()}
    found, sizes = list[ForkEffect](), Counter(baseline[agent] for agent in {agent for agent, *_ in placed})
    for (agent, condition, truthful), there in placed.items():
        agents, keys = sizes[baseline[agent]], dict.fromkeys(key for key, _ in there)
        steps = [str(at) for at in sorted({at for _, at in there})]
        asked = [*steps, *(rule for rule in RULES if rule != "every")] if rules is None else rules
        arms = dict.fromkeys(arm for at in there.values() for arm in at if arm != TRUTH)
        for where in dict.fromkeys(one for rule in asked for one in (steps if rule == "every" else [rule])):
            points = [(key, at) for key in keys for at in fork_steps(parents[key], where)]
            for arm in arms:
                forked = [point for point in points if arm in there.get(point, ())]
                if len(forked) < (len(points) if rules is None else 2):
                    continue
                for outcome in OUTCOMES:
                    pairs = [_pairs(there[point], parents[point[0]], point[1], arm, outcome) for point in forked]
                    if len(own := [one for one in pairs if one is not None]) > 1:
                        of = _effect(own, outcome, budget, agents)
                        found.append(ForkEffect(agent, condition, where, arm, truthful, outcome, *of, agents))
    success = [i for i, one in enumerate(found) if one.outcome == "success"]
    tested = [found[i].change.p_value for i in success]
    for i, value in zip(success, holm_by_family([found[i].agent for i in success], tested), strict=True):
        found[i] = found[i]._replace(change=replace(found[i].change, p_value=value))
    return found


def _pairs(arms: Mapping[str, Mapping[int, Trial]], parent: Trial, at: int, arm: str, outcome: str) -> Array | None:
    """Outcomes of an arm and of a true report, one row per continuation; None if either is missing.

    If continuations share no luck, one true report may serve several rows: it is the recorded trial.
    """
    told, changed = arms.get(TRUTH), arms.get(arm)
    if not told or not changed:
        return None
    base = {time: _outcome(fork, parent, at, outcome) for time, fork in told.items()}
    only = next(iter(base.values())) if len(base) == 1 else math.nan
    pairs = np.array([(_outcome(fork, parent, at, outcome), base.get(time, only)) for time, fork in changed.items()])
    kept = pairs[~np.isnan(pairs).any(axis=1)]
    return kept if len(kept) else None


def _outcome(fork: Trial, parent: Trial, at: int, outcome: str) -> float:
    following = fork.steps[at].joint
    match outcome:
        case "success":
            return float(fork.solved)
        case "steps":
            return float(len(fork.steps) if fork.solved else fork.budget)
        case "repeats":
            return float(following == parent.steps[at - 1].joint)
    on = continuation(parent.actions[:at])
    return math.nan if on is None else float(following != on)


def _effect(trials: Sequence[Array], outcome: str, budget: int, agents: int) -> tuple[float, Difference]:
    """The mean after a true report, and the change, from the pairs of each trial."""
    differences = np.full((len(trials), max(map(len, trials))), np.nan)
    for row, pairs in zip(differences, trials, strict=True):
        row[: len(pairs)] = pairs[:, 0] - pairs[:, 1]
    changed, told = np.concatenate(trials).T
    unit, rare = (float(budget), rare_block(told, changed, budget)) if outcome == "steps" else (1.0, None)
    return float(told.mean()), mean_of_blocks(differences, unit=unit, choices=agents, rare=rare)
