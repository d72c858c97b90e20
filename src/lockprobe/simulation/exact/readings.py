"""Success under each reading of a false report, and under its parts: exact, or sampled where states are too many."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import nan
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.formatting import markdown_table
from lockprobe.foundation.validation import check_probability
from lockprobe.interventions.conditions import interventions_in, read_condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.exact.markov_chain import TooManyStates
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.simulation.montecarlo.plain import policy_of
from lockprobe.simulation.montecarlo.populations import population
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import Condition

__all__ = ["AGENTS", "FALSE_REPORTS", "P", "SuccessUnder", "as_table", "cell", "conditions_table", "success_under"]

AGENTS = ("human-inspired", "cognitive:perseverant", "cognitive:insistent", "cognitive:careful")
"""Agents whose success is exact under all of them."""

P = (0.0, 0.2, 0.4, 0.6)
"""Rates of false reports, [0, 1]."""

FALSE_REPORTS = {
    "re-observed outcome noise": "flip?p={p}",
    "integrated outcome noise": "flip?p={p}&others=kept",
    "memoryless state noise": "flip?p={p}&inverts=position",
    "latched state noise": "flip?p={p}&inverts=position&others=kept",
    "independent state noise": "flip?p={p}&inverts=position&others=noisy",
    "outcome noise, no positions": "flip?p={p} + symbolic?tell=outcome",
    "both parts": "flip?p={p}&inverts=position + symbolic",
    "false outcome alone": "flip?p={p}&part=outcome + symbolic",
    "false position alone": "flip?p={p}&inverts=position&part=position + symbolic",
    "phantom": "phantom?p={p}",
    "phantom, outcomes told": "phantom?p={p} + symbolic",
    "hidden moves alone": "flip?p={p}&inverts=position&only=moved",
    "invented moves alone": "flip?p={p}&inverts=position&only=blocked",
}
"""Name of a false report -> its condition at rate ``{p}``: first the readings, then the parts of memoryless noise."""

_FOLLOWED = 5_000
"""Agents with more states are sampled."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessUnder:
    """How an agent does under one kind of false report at one rate.

    Attributes:
        agent: Spec of the agent.
        name: What a false report is.
        condition: Spec of the condition.
        p: Rate, [0, 1].
        success: Probability to solve the box within the budget, or the share of trials that did, [0, 1].
        low, high: Ends of its 95 % interval; equal to it where it is exact.
        false_outcomes: Share of reports in trials that go on whose outcome, told or inferred, is the opposite of the
            true one, [0, 1]; NaN if there is no report.
        trials: Number of trials; None where it is exact.
    """

    agent: str
    name: str
    condition: str
    p: float
    success: float
    low: float
    high: float
    false_outcomes: float
    trials: int | None = None


def success_under(
    agents: Sequence[str] = AGENTS,
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: Sequence[float] = P,
    names: Sequence[str] = tuple(FALSE_REPORTS),
    max_steps: int = 20,
    trials: int = 1_500,
    seed: int = 1,
    begun: Callable[[str], None] = lambda _: None,
) -> list[SuccessUnder]:
    """The success of agents under the kinds of false reports, by agent, kind and rate.

    Args:
        agents: Specs of agents that are policies.
        box: Name of a box, path of a TOML file, or a box.
        p: Rates, [0, 1].
        names: Kinds, of :data:`FALSE_REPORTS`.
        max_steps: Budget in steps.
        trials: Trials a cell of an agent that has to be sampled. They are the first of a study with this seed.
        seed: Seed of that study.
        begun: Called with each agent before it plays.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or an agent is no policy.
    """
    for rate in p:
        check_probability("rate p", rate)
    for agent in agents:
        policy_of(agent)
    found = []
    for agent in agents:
        begun(agent)
        refused: set[bool] = set()  # without and with false reports, which make states many
        for name in names:
            for rate in p:
                condition = read_condition(FALSE_REPORTS[name].format(p=f"{rate:g}"))
                one = None if (rate > 0) in refused else _exact(agent, name, condition, rate, box, max_steps)
                if one is None:
                    refused.add(rate > 0)
                    one = _sampled(agent, name, condition, rate, box, max_steps, trials=trials, seed=seed)
                found.append(one)
    return found


def _exact(
    agent: str, name: str, condition: Condition, p: float, box: str | Path | Lockbox, max_steps: int
) -> SuccessUnder | None:
    """The exact success; None if the agent has too many states."""
    try:
        course = propagate(
            agent,
            box,
            condition=interventions_in(condition),
            modality=condition.modality,
            max_steps=max_steps,
            most_states=_FOLLOWED,
        )
    except TooManyStates:
        return None
    return SuccessUnder(
        agent=agent,
        name=name,
        condition=condition.spec,
        p=p,
        success=course.success,
        low=course.success,
        high=course.success,
        false_outcomes=course.false_outcomes,
    )


def _sampled(
    agent: str,
    name: str,
    condition: Condition,
    p: float,
    box: str | Path | Lockbox,
    max_steps: int,
    *,
    trials: int,
    seed: int,
) -> SuccessUnder:
    """The share of trials that solved the box, without records where every report can be inverted."""
    acting = interventions_in(condition)
    flip = acting[0]
    if isinstance(flip, OutcomeFlip) and flip == flip.at_rate(flip.p):
        played = population(
            agent,
            box,
            p=flip.p,
            flip=flip,
            modality=condition.modality,
            trials=trials,
            seed=seed,
            max_steps=max_steps,
            record=True,
        )
        assert played.moved is not None
        assert played.told_moved is not None
        given = np.arange(max_steps) < (played.steps - played.solved)[:, None]  # nothing is told of the last attempt
        solved, false = int(played.solved.sum()), (played.moved != played.told_moved)[given]
    else:
        records = [
            run_trial(
                agent=agent,
                box=box,
                condition=list(acting),
                modality=condition.modality,
                seed=seed,
                trial=trial,
                max_steps=max_steps,
            )
            for trial in range(1, trials + 1)
        ]
        solved = sum(trial.solved for trial in records)
        ends = [step.told_falsely for trial in records for step in trial.steps[: len(trial.steps) - trial.solved]]
        false = np.array(ends, dtype=bool)
    share = proportion(solved, trials)
    return SuccessUnder(
        agent=agent,
        name=name,
        condition=condition.spec,
        p=p,
        success=share.value,
        low=share.low,
        high=share.high,
        false_outcomes=float(false.mean()) if len(false) else nan,
        trials=trials,
    )


def conditions_table() -> str:
    """The kinds of false reports and their conditions at rate P, as a Markdown table."""
    lines = [(name, f"`{condition.format(p='P')}`") for name, condition in FALSE_REPORTS.items()]
    return markdown_table(("false report", "condition"), *lines)


def as_table(found: Sequence[SuccessUnder]) -> str:
    """Markdown tables, one for each agent: success, and in brackets the share of false outcomes.

    A sampled success is followed by half the width of its 95 % interval.
    """
    tables = []
    for agent, of_agent in groupby(found, key=lambda one: one.agent):
        rows = [list(of_kind) for _, of_kind in groupby(of_agent, key=lambda one: one.name)]
        head = [f"`{agent}`, by flip rate", *(f"{one.p:g}" for one in rows[0])]
        tables.append(markdown_table(head, *([row[0].name, *map(cell, row)] for row in rows), numbers=True))
    return "\n\n".join(tables)


def cell(one: SuccessUnder) -> str:
    """``0.653 [0.40]``, or of a sample ``0.653 ± 0.024 [0.40]``."""
    width = "" if one.trials is None else f" ± {(one.high - one.low) / 2:.3f}"
    return f"{one.success:.3f}{width} [{one.false_outcomes:.2f}]"
