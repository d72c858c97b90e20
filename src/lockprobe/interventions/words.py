"""The symbolic observation in words (paper, Sec. 2.2: predefined labels of each joint and its state)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lockprobe.record import Moment, Percept, Task

__all__ = ["TextChannel"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TextChannel:
    """Writes the percept as sentences; it adds and hides nothing."""

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """The percept with its text."""
        sentences = []
        if percept.joint is not None and percept.outcome is not None:
            sentences.append(f"{percept.joint} {'moved' if percept.outcome == 'moved' else 'did not move'}.")
        if percept.positions is not None:
            there = [label for label, position in zip(task.joints, percept.positions, strict=True) if position]
            sentences.append(f"At 1: {', '.join(there) or 'none'}.")
        return replace(percept, text=" ".join(sentences))
