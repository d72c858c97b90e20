"""Cost estimates of forks, from the recorded calls of their parent trials."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from lockprobe.studies.branch import Branching
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import hosted, price_of


@dataclass(frozen=True, slots=True, kw_only=True)
class ForkCost:
    """The estimated cost of one agent's forks.

    Attributes:
        agent: Agent spec.
        forks: Number of forks.
        steps: Upper bound of their steps.
        hosted: Whether a provider charges for them.
        dollars: US dollars if they end at the same step as the recorded trials; None if not known.
        most_dollars: US dollars if none is solved, without retries of malformed replies; None if not known.
    """

    agent: str
    forks: int
    steps: int
    hosted: bool
    dollars: float | None = None
    most_dollars: float | None = None


def fork_costs(asked: Branching, directory: Path | str) -> list[ForkCost]:
    """Estimate the cost of forks from the calls of their study. Forks already played count too.

    Args:
        asked: The forks.
        directory: The directory of their study.
    """
    found = []
    for agent in asked.agents:
        names = [plan.fork.name for plan in asked.plans(agent) if plan.fork is not None]
        budget, paid = asked.study.max_steps, agent in hosted(asked.study)
        steps = sum(budget - name.at for name in names)
        by_step = _dollars_by_step(asked, directory, agent) if paid else None
        if by_step is None:
            found.append(ForkCost(agent=agent, forks=len(names), steps=steps, hosted=paid))
            continue
        ends = [len(asked.trials[name.parent].steps) for name in names]
        dollars = sum(sum(by_step[name.at : end]) for name, end in zip(names, ends, strict=True))
        most = sum(sum(by_step[name.at :]) for name in names)
        known = ForkCost(agent=agent, forks=len(names), steps=steps, hosted=True, dollars=dollars, most_dollars=most)
        found.append(known)
    return found


def _dollars_by_step(asked: Branching, directory: Path | str, agent: str) -> list[float] | None:
    """The mean cost of each recorded step, US dollars; later steps cost as much as the last. None if not known."""
    if (price := price_of(agent)) is None:
        return None
    spent: defaultdict[int, float] = defaultdict(float)
    trials: defaultdict[int, set[str]] = defaultdict(set)
    for call in read_calls(directory):
        if call.key in asked.trials and asked.trials[call.key].agent == agent and call.step:
            spent[call.step] += price.of(call.usage)
            trials[call.step].add(call.key)
    if not spent:
        return None
    found = [spent[step] / len(trials[step]) if trials[step] else 0.0 for step in range(1, max(spent) + 1)]
    return found + [found[-1]] * (asked.study.max_steps - len(found))
