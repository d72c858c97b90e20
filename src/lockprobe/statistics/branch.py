"""The effect of one report, from forks of recorded trials.

A fork replays a recorded trial up to one report, changes that report, and lets the agent play on. Arms share the past
and, if the agent is seeded, the luck of the future. So the difference between two arms is the effect of that report
alone. Forks also measure the first lie in a truthful world, which the records of a study cannot give.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.blocks import Array, mean_of_blocks, rare_block
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.loops import onset
from lockprobe.statistics.multiple_testing import holm
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Difference
from lockprobe.trial.record import Trial
from lockprobe.trial.source import false_reports

RULES = ("onset", "first-lie", "every")
"""Where a trial can be forked, in addition to a step's number: at the report that completes its first loop; at its
first false report; after every step."""

TRUTH = "truth"
"""The arm with which others are compared."""

OUTCOMES: Mapping[str, str] = {"success": "points", "steps": "steps", "repeats": "points"}
"""Outcome -> the unit of its change. The box is solved; steps that the whole trial takes, its budget where it is not
solved; the next action repeats that of the fork."""


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


def check_rule(rule: str) -> None:
    """Refuse a rule that is neither a step from 1 nor one of :data:`RULES`."""
    if rule not in RULES and not (rule.isdecimal() and int(rule) >= 1):
        raise BadValue("at", rule, f"a step from 1, or one of {', '.join(RULES)}")


def fork_steps(trial: Trial, rule: str) -> tuple[int, ...]:
    """The steps after whose reports a rule forks a trial, which must have gone on; refused as by :func:`check_rule`."""
    check_rule(rule)
    last = len(trial.steps) - 1
    if rule == "every":
        return tuple(range(1, last + 1))
    if rule == "first-lie":
        found = next((n for n, false in enumerate(false_reports(trial), 1) if false), 0)
    else:
        found = onset(trial.actions) if rule == "onset" else int(rule)
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
                    pairs = [_pairs(there[point], arm, outcome) for point in forked]
                    if len(own := [one for one in pairs if one is not None]) > 1:
                        of = _effect(own, outcome, budget, agents)
                        found.append(ForkEffect(agent, condition, where, arm, truthful, outcome, *of, agents))
    success = [i for i, one in enumerate(found) if one.outcome == "success"]
    tested = [found[i].change.p_value for i in success]
    for i, value in zip(success, holm(tested, [found[i].agent for i in success]), strict=True):
        found[i] = found[i]._replace(change=replace(found[i].change, p_value=value))
    return found


def _pairs(arms: Mapping[str, Mapping[int, Trial]], arm: str, outcome: str) -> Array | None:
    """Outcomes of an arm and of a true report, one row per continuation; None if either is missing.

    If continuations share no luck, one true report may serve several rows: it is the recorded trial.
    """

    def of(fork: Trial) -> float:
        if outcome == "success":
            return float(fork.solved)
        if outcome == "steps":
            return float(len(fork.steps) if fork.solved else fork.budget)
        at = fork.fork.at if fork.fork else 0
        return float(fork.steps[at].joint == fork.steps[at - 1].joint)

    told, changed = arms.get(TRUTH, {}), arms.get(arm, {})
    only = next(iter(told.values())) if len(told) == 1 else None
    base = {time: true for time in changed if (true := told.get(time, only)) is not None}
    pairs = np.array([(of(changed[time]), of(true)) for time, true in base.items()])
    return pairs if len(pairs) else None


def _effect(trials: Sequence[Array], outcome: str, budget: int, agents: int) -> tuple[float, Difference]:
    """The mean after a true report, and the change, from the pairs of each trial."""
    differences = np.full((len(trials), max(map(len, trials))), np.nan)
    for row, pairs in zip(differences, trials, strict=True):
        row[: len(pairs)] = pairs[:, 0] - pairs[:, 1]
    changed, told = np.concatenate(trials).T
    unit, rare = (float(budget), rare_block(told, changed, budget)) if outcome == "steps" else (1.0, None)
    return float(told.mean()), mean_of_blocks(differences, unit=unit, choices=agents, rare=rare)
