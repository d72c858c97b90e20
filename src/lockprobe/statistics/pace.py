"""The speed of two agents compared: hazard ratio and log-rank tests (paper, Fig. 3)."""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.inference.logrank import bounded_speed, independent_logrank
from lockprobe.statistics.outcomes import joined, with_players_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Pace:
    """The speed of two agents, or of one agent in two modalities, at one p.

    Attributes:
        first, second: Agent and modality of each.
        dose: The dose: flip probability, [0, 1], or another.
        hazard_ratio: Hazard ratio of solving, second over first: above 1 if the second is faster; None if undefined.
        p_value: Log-rank, two-sided, clustered by luck, or by player. It holds whatever became of broken trials.
        independent: P value of the log-rank test for independent trials; None if undefined, or if trials broke.
        gehan: The same with Gehan-Wilcoxon weights, which have more power for early differences.
    """

    first: tuple[str, str]
    second: tuple[str, str]
    dose: float
    hazard_ratio: float | None
    p_value: float | None
    independent: float | None
    gehan: float | None


def pace(first: AxisTrials, second: AxisTrials) -> Pace | None:
    """Compare two agents at one dose on trials with shared luck; None if one has no ended trial."""
    one, two = first.outcomes, second.outcomes
    if not len(one) or not len(two):
        return None
    broken = with_players_of(two, first.broken_off), with_players_of(one, second.broken_off)
    one, two = with_players_of(two, one), with_players_of(one, two)
    both, known = joined([one, two]), not any(map(len, broken))
    found = bounded_speed(one, two, *broken, max(first.budget, second.budget))
    return Pace(
        first=(first.agent, first.modality),
        second=(second.agent, second.modality),
        dose=first.doses[0],
        hazard_ratio=found.hazard_ratio if found else None,
        p_value=found.p_value if found else None,
        independent=independent_logrank(both.length, both.solved, both.dose > 0) if known else None,
        gehan=independent_logrank(both.length, both.solved, both.dose > 0, weights="running") if known else None,
    )
