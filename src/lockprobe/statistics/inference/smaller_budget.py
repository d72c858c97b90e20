"""Smaller budgets: whether an effect on success reverses if trials end earlier.

An agent may solve more boxes within the whole budget and fewer within a part of it, because its curves of success
cross. Every trial records the step at which it was solved, so the same trials are compared at every smaller budget.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from lockprobe.statistics.inference.difference import AnyDifference
from lockprobe.statistics.outcomes import Outcomes, solved_in_pairs
from lockprobe.statistics.proportions import ALPHA, Proportion, paired, proportion

__all__ = ["Reversal", "reversal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reversal:
    """The clearest smaller budget at which the difference in success has the opposite sign.

    Attributes:
        budget: Steps, fewer than the whole budget.
        lowest: The lowest p.
        clearest: The p of the clearest difference.
        first: Solved within these steps at the lowest p.
        second: The same at the p of the clearest difference.
        p_value: McNemar's exact test, corrected for all smaller budgets and for the agents that are judged together
            (Bonferroni), below 0.05.
    """

    budget: int
    lowest: float
    clearest: float
    first: Proportion
    second: Proportion
    p_value: float


def reversal(outcomes: Outcomes, found: AnyDifference) -> Reversal | None:
    """Look for a smaller budget with the opposite effect at the lowest p and the p of the clearest difference.

    The p is the one that differs most clearly within the whole budget, so it is not chosen for a reversal.

    Args:
        outcomes: The ended trials of one agent.
        found: Its differences in success.

    Returns:
        None if no difference was detected, no smaller budget reverses it, trials do not come in pairs (people), or what
        is said must hold at every look.
    """
    least, clearest = found.lowest, found.clearest
    if least is None or clearest is None or clearest.p_value >= ALPHA or outcomes.crossed or outcomes.order is not None:
        return None
    lowest, higher = (outcomes.at(outcomes.dose == p) for p in (least, clearest.dose))
    budgets = range(1, int(outcomes.length.max()))
    reversed_at: list[Reversal] = []
    for budget in budgets:
        one, two = solved_in_pairs(_within(lowest, budget), _within(higher, budget)).T
        test = paired(one, two)
        if test.value * clearest.value < 0 and (p_value := test.p_value * len(budgets) * found.agents) < ALPHA:
            first, second = (proportion(int(solved.sum()), len(solved)) for solved in (one, two))
            reversed_at.append(
                Reversal(
                    budget=budget,
                    lowest=least,
                    clearest=clearest.dose,
                    first=first,
                    second=second,
                    p_value=p_value,
                )
            )
    return min(reversed_at, key=lambda one: (one.p_value, one.budget), default=None)


def _within(trials: Outcomes, budget: int) -> Outcomes:
    """The same trials as a smaller budget would have ended them."""
    return replace(trials, solved=trials.solved & (trials.length <= budget))
