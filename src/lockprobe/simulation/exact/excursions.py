"""The exact effect of one false report on success, by step: the reference for estimates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lockprobe.agents.policy import Policy
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact.propagation import propagate

__all__ = ["LieEffects", "lie_effects", "one_lie"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LieEffects:
    """The exact effects of one false report.

    Attributes:
        by_step: The change of success by a lie instead of a true report at step 1, 2, ..., among trials that go on
            after that step, [-1, 1]. The last step, which nothing follows, is left out.
        running: The share of trials that go on after each of these steps, [0, 1].
    """

    by_step: tuple[float, ...]
    running: tuple[float, ...]

    @property
    def mean(self) -> float:
        """The mean over all reports after which a trial goes on."""
        return sum(a * b for a, b in zip(self.by_step, self.running, strict=True)) / sum(self.running)


def lie_effects(
    agent: str | Policy[Any] = "human-inspired",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    modality: str | None = None,
    max_steps: int = 20,
) -> LieEffects:
    """The effect of a lie at each step, if all other reports are false with probability p.

    With p = 0 it is the effect of a single lie in a truthful world. The other arguments are those of
    :func:`lockprobe.propagate`; the budget has at least 2 steps.

    Raises:
        UserMistake: As :func:`lockprobe.propagate`.

    >>> [round(effect, 2) for effect in lie_effects("human-inspired", max_steps=6).by_step]
    [0.0, 0.17, 0.0, 0.17, 0.0]
    """
    if max_steps < 2:
        raise BadValue("max_steps", max_steps, "at least 2, so that a report has a future")
    course = propagate(agent, box, p=p, modality=modality, max_steps=max_steps)
    running = tuple(1 - solved for solved in course.solved[1:max_steps])
    effects = []
    for step, share in enumerate(running, 1):
        told = [
            propagate(agent, box, condition=one_lie(step, rate, p), modality=modality, max_steps=max_steps).success
            for rate in (0.0, 1.0)
        ]
        effects.append((told[1] - told[0]) / share if share > 0 else 0.0)
    return LieEffects(by_step=tuple(effects), running=running)


def one_lie(step: int, rate: float, p: float) -> str:
    """The spec of flips at one rate at one step and at rate p at all other steps."""
    flips = [f"flip?p={p}&until={step - 1}"] if step > 1 else []
    return " + ".join([*flips, f"flip?p={rate}&at={step}", f"flip?p={p}&from={step + 1}"])
