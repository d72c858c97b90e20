"""Fits one or two parameters of a cognitive agent to the choices of an agent, by maximum likelihood.

    python examples/fit_policy.py STUDY --agent human-inspired --policy cognitive:softmax-memory --fit failure,recent

``--policy`` is any agent that is a ``Policy``; ``--fit`` names numbers among its options. The policy hears what the
agent was told, and its probabilities of the agent's choices are multiplied. Reports are taken as of the last attempt,
and remembered: leave conditions with ``delay`` or ``history`` out by ``--condition``.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize

import lockprobe
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import Policy, Told, View

SHARES = ("decay", "reset", "lapse")
"""Parameters from 0 to 1; all others are pulls, and 15 is always."""

LEAST = 1e-9
"""The probability of a choice that a policy rules out."""


@dataclass(frozen=True)
class Heard:
    """A trial as a policy knows it: joints by their numbers in the list, and after each choice its report, or None."""

    view: View
    chosen: tuple[int, ...]
    told: tuple[Told | None, ...]


def heard(trial: lockprobe.Trial) -> Heard:
    """A recorded trial as a policy would have heard it."""
    panel = [trial.labels.index(label) for label in trial.listing]
    number = {trial.joints[place]: joint for joint, place in enumerate(panel)}
    start = trial.steps[0].state if trial.steps else ""

    def report(step: lockprobe.Step) -> Told | None:
        if step.told_moved is None:
            return None
        seen = None
        if step.told_state is not None and not step.pictures:
            seen = sum((step.told_state[place] != start[place]) << joint for joint, place in enumerate(panel))
        return Told(joint=number[step.joint], moved=step.told_moved, shifted=seen, states_only=trial.states_only)

    return Heard(
        view=View(joints=len(panel), target=number[trial.target]),
        chosen=tuple(number[step.chosen or step.joint] for step in trial.steps),
        told=tuple(map(report, trial.steps)),
    )


def log_likelihood(policy: Policy[Any], trials: Sequence[Heard]) -> float:
    """The logarithm of the probability that a policy makes all choices."""
    total = 0.0
    for trial in trials:
        memory = policy.begin(trial.view)
        for joint, told in zip(trial.chosen, trial.told, strict=True):
            total += math.log(max(policy.probabilities(trial.view, memory)[joint], LEAST))
            if told is None:
                memory = policy.remember_silence(trial.view, memory, joint)
            else:
                memory = policy.remember(trial.view, memory, told)
    return total


def fit(policy: Any, names: Sequence[str], trials: Sequence[Heard]) -> tuple[dict[str, float], float]:
    """The parameters of greatest likelihood, and its logarithm."""

    def lost(values: np.ndarray) -> float:
        return -log_likelihood(replace(policy, **dict(zip(names, map(float, values), strict=True))), trials)

    bounds = [(0, 1) if name in SHARES else (-15, 15) for name in names]
    found = minimize(lost, [0.5] * len(names), method="Nelder-Mead", bounds=bounds, options={"xatol": 0.01})
    return dict(zip(names, map(float, found.x), strict=True)), -float(found.fun)


def main() -> None:
    """Print the estimates, and the log-likelihood beside that of a random agent."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("--agent", required=True, help="the agent whose choices are fitted, as its study names it")
    parser.add_argument("--policy", default="cognitive:softmax-memory")
    parser.add_argument("--fit", default="failure,recent", help="one or two parameters")
    parser.add_argument("--condition", help="trials under this condition alone")
    parser.add_argument("--trials", type=int, default=200, help="so many trials, drawn at random")
    asked = parser.parse_args()
    found = [one for one in lockprobe.load(asked.study) if one.agent == asked.agent and one.steps]
    found = [one for one in found if asked.condition in (None, one.condition)]
    if not found:
        parser.error(f"no trial of {asked.agent} there")
    drawn = np.random.default_rng(1).permutation(len(found))[: asked.trials]
    trials = [heard(found[number]) for number in drawn]
    estimates, likelihood = fit(resolve(asked.policy).make(), asked.fit.split(","), trials)
    said = ", ".join(f"{name} {value:.2f}" for name, value in estimates.items())
    blind = -sum(len(one.chosen) * math.log(one.view.joints) for one in trials)
    choices = sum(len(one.chosen) for one in trials)
    print(f"{asked.agent}, {len(trials)} trials, {choices} choices, as {asked.policy}: {said}")
    print(f"log-likelihood {likelihood:.1f}; of random choices {blind:.1f}")


if __name__ == "__main__":
    main()
