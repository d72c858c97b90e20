"""Simulated agents with known truth (worlds), and the sizes of their studies.

A *world* states the success at each p and the agent's tendency to fall into cycles. Nothing else differs
between conditions. :mod:`lockprobe.simulation.power.simulate` plays them.
"""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.statistics.inference.over_doses import Question

P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """The size of a study; the paper's flip study by default (Sec. 3.2).

    Attributes:
        p: Flip probabilities, ascending.
        repetitions: Repetitions of the design.
        trials: Trials per repetition and p.
    """

    p: tuple[float, ...] = P
    repetitions: int = 3
    trials: int = 10

    @property
    def clusters(self) -> int:
        """Trials per p."""
        return self.repetitions * self.trials


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A world: the truth about a simulated agent. ``success`` and ``trap`` have one value per p, ascending.

    Attributes:
        name: Its name.
        says: The truth in one sentence.
        success: Probability of solving the box within the budget, [0, 1].
        trap: Probability per step of falling into a cycle of three or four actions, [0, 1]; 0 acts at random
            throughout.
        truths: Questions whose true answer is yes.
    """

    name: str
    says: str
    success: tuple[float, ...]
    truths: frozenset[Question]
    trap: tuple[float, ...] = (0.0,) * len(P)
