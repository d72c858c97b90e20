"""Two agents where trials of one of them broke: only what holds whatever became of those is concluded.

A trial that broke for one agent drops its pair. Where the long trials of an agent break, those that remain flatter it.
So every comparison is made three times: without the broken trials, with all of them unsolved, and with all of them
solved at the next step (:mod:`lockprobe.analysis.inference.broken_trials` does the same between conditions).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lockprobe.analysis.agent_comparison.interaction import Interaction
from lockprobe.analysis.agent_comparison.pair import Comparison, ComparisonAt
from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.inference.broken_trials import completed
from lockprobe.analysis.outcomes import Outcomes

__all__ = ["agreed", "both_ends"]


def both_ends(counted: Outcomes, broken: Outcomes, budget: int) -> tuple[Outcomes, Outcomes]:
    """All trials of an agent: those that broke unsolved, at the whole budget; and solved, at the step after their last.

    Args:
        counted: Its ended trials.
        broken: Its trials that ended as error.
        budget: Steps of a trial.
    """
    unsolved, solved = completed(counted, broken)
    beyond = np.arange(len(unsolved)) >= len(counted)
    return replace(unsolved, length=np.where(beyond, budget, unsolved.length)), solved


def agreed(found: Comparison, ends: tuple[Comparison, Comparison]) -> Comparison:
    """The comparison without the broken trials, with p-values that hold at both ends too.

    Args:
        found: The two agents over the trials that both finished.
        ends: The same with all broken trials unsolved, and with all solved.
    """
    return replace(
        found,
        success=_mean(found.success, *(end.success for end in ends)),
        steps=_mean(found.steps, *(end.steps for end in ends)),
        at=tuple(_at(one, [{at.p: at for at in end.at}[one.p] for end in ends]) for one in found.at),
        interaction=_interaction(found.interaction, *(end.interaction for end in ends)),
        bounded=True,
    )


def _mean(*three: BlockMean) -> BlockMean:
    """The first, with the largest p-value; 1 where signs differ, or an interval holds 0 and the first does not."""
    values = [one.p_value for one in three if one.p_value is not None]
    if len(values) < len(three):
        return replace(three[0], p_value=None)
    holds = len({np.sign(one.value) for one in three}) == 1 and all(one.clear >= three[0].clear for one in three)
    return replace(three[0], p_value=max(values) if holds else 1.0)


def _at(found: ComparisonAt, ends: list[ComparisonAt]) -> ComparisonAt:
    three = [found, *ends]
    alike = len({np.sign(one.success.value) for one in three}) == 1
    success = replace(found.success, p_value=max(one.success.p_value for one in three) if alike else 1.0)
    return replace(found, success=success, steps=_mean(*(one.steps for one in three)))


def _interaction(found: Interaction | None, *ends: Interaction | None) -> Interaction | None:
    if found is None:
        return None
    three = [found, *(end for end in ends if end is not None)]
    signs = {
        np.sign(change.value) for one in three for at in one.at if at.p == found.clearest.p for change in [at.change]
    }
    return replace(found, p_value=max(one.p_value for one in three) if len(three) == 3 and len(signs) == 1 else 1.0)
