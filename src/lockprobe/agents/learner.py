"""The agent ``learner:NAME``: a small network that the project trains itself (:mod:`lockprobe.agents.network`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.agents.network.network import encoded
from lockprobe.agents.network.network_file import SHIPPED, Learned, load, shipped
from lockprobe.agents.policy import Policy, Told, View, opened_after
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import arguments_from
from lockprobe.trial.record import Fact

__all__ = ["Learner", "Recurrent"]

_DIGITS = 9
"""Decimals of its state and of its chances. Processors differ after the fifteenth; rounded, records are the same."""


@dataclass(frozen=True, slots=True)
class Recurrent:
    """The memory of a learner.

    Attributes:
        state: Its recurrent state, H numbers of 64 bits.
        opened: Joints believed away from their start, bit j for joint j.
    """

    state: bytes
    opened: int = 0


@dataclass(frozen=True, kw_only=True)
class Learner(Policy[Recurrent]):
    """A trained network that takes each joint with the probability it gives.

    It reads the joint attempted last, the report on it, the joints reported away from their start, and the target. A
    correction or a remark changes nothing.

    Attributes:
        learned: The network.
        temperature: At least 0: choice probabilities are proportional to exp(logit / temperature); 0 takes the
            likeliest joint.

    Raises:
        BadValue: If ``temperature`` is below 0 or no number.
    """

    learned: Learned
    temperature: float = 1.0

    exact = True

    def __post_init__(self) -> None:
        if not 0 <= self.temperature <= 1000:
            raise BadValue("temperature", self.temperature, "a number from 0 to 1000")

    @classmethod
    def from_options(cls, name: str, options: Mapping[str, str]) -> Learner:
        """The agent of a spec: one of those that ship, or the one in a file.

        Raises:
            BadFile: If the file is no learner.
            UserMistake: If there is no such option, or as the class.
        """
        asked: dict[str, Any] = arguments_from(cls, f"learner:{name}", options, taken=("learned",))
        return cls(learned=shipped(name) if name in SHIPPED else load(Path(name)), **asked)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its file, how it was trained, and the temperature."""
        trained = self.learned.trained
        return {
            "sha256": self.learned.sha256,
            "training": trained.command,
            "updates": trained.updates,
            "temperature": self.temperature,
        }

    def begin(self, view: View) -> Recurrent:
        """Its state after it has read which joint is the target.

        Raises:
            BadValue: If it was trained for another number of joints.
        """
        known = self.learned.network.joints
        if view.joints != known:
            more = f"lockprobe learn --joints {view.joints} --out FILE trains one for {view.joints}"
            raise BadValue("box", f"{view.joints} joints", f"{known}, the number that this learner learned; {more}")
        return self._read(view, Recurrent(np.zeros(self.learned.network.hidden).tobytes()), -1, 0.0, 0)

    def remember(self, view: View, memory: Recurrent, told: Told) -> Recurrent:
        """Its state after a report."""
        moved = 1.0 if told.moved else -1.0
        return self._read(view, memory, told.joint, moved, opened_after(memory.opened, told))

    def remember_silence(self, view: View, memory: Recurrent, joint: int) -> Recurrent:
        """Its state after an attempt of which nothing is told."""
        return self._read(view, memory, joint, 0.0, memory.opened)

    def probabilities(self, view: View, memory: Recurrent) -> tuple[float, ...]:
        """The probability of each joint; of several likeliest ones the first at temperature 0."""
        logits = self.learned.network.logits(np.frombuffer(memory.state)[None])[0].round(_DIGITS)
        if not self.temperature:
            return tuple(float(joint == logits.argmax()) for joint in range(view.joints))
        raised = np.exp((logits - logits.max()) / self.temperature)
        return tuple((raised / raised.sum()).round(_DIGITS).tolist())

    def _read(self, view: View, memory: Recurrent, joint: int, moved: float, opened: int) -> Recurrent:
        positions = ((opened >> np.arange(view.joints)) & 1).astype(np.float64)[None]
        read = encoded(np.array([joint]), np.array([moved]), positions, np.array([view.target]))
        after = self.learned.network.step(read, np.frombuffer(memory.state)[None]).after
        return Recurrent(after.round(_DIGITS).tobytes(), opened)
