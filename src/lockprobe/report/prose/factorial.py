"""Sentences on a factorial design: how much each factor does to misreading and to success."""

from __future__ import annotations

from lockprobe.foundation.formatting import bracketed, listed, percent
from lockprobe.statistics.factorial.effects import FactorEffect, FactorialEffects


def factor_said(factor: str) -> str:
    """A factor with its named level, without the plant whose option it is.

    >>> factor_said("plant.light=side"), factor_said("tremble.p=0.1")
    ('light=side', 'tremble.p=0.1')
    """
    return factor.removeprefix("plant.")


def factorial_said(found: FactorialEffects) -> str:
    """Which factors change misreading, or else success, and by how much."""
    said, levels = [], found.design.levels
    for measure, mean in found.means.items():
        if measure == "misreading" and not mean:
            said.append(
                f"{found.agent} misreads no outcome in {len(found.design.runs)} scenes, so no factor matters to it"
            )
            continue
        if measure == "misreading":
            scenes = len(found.design.runs)
            said.append(f"{found.agent} misreads {percent(mean, 1)} of the outcomes of a trial, over {scenes} scenes")
        clear = [one for one in found.of(measure) if one.detected]
        if clear:
            said.append(f"{measure} changes with {listed([_size(one, levels[one.factor][1]) for one in clear])}")
        else:
            said.append(f"no factor is shown to change {measure}")
    return "; ".join(said) + "."


def _size(one: FactorEffect, level: str) -> str:
    return f"{factor_said(f'{one.factor}={level}')} ({bracketed(one.value, one.low, one.high)} points)"
