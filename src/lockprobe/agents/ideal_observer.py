"""The ideal observer: exact Bayesian inference from reports under a given prior, and planning by the posterior.

It shows how much information reports contain, and is ideal only under its prior and noise model. Beliefs and plans are
:mod:`lockprobe.boxes.beliefs`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from lockprobe.agents.policy import Policy, Told, View
from lockprobe.boxes.beliefs import PRIORS, Belief, KnownReading, begin, interlocks, noise_model, update
from lockprobe.boxes.planning import best_joints
from lockprobe.foundation.errors import UnknownName
from lockprobe.trial.record import Outcome


@dataclass(frozen=True, kw_only=True)
class IdealObserver(Policy[Belief]):
    """Infers the interlock from all reports (Bayesian) and plans by the posterior.

    Ties between joints are drawn at random.

    Attributes:
        prior: The interlocks that it considers possible: :mod:`lockprobe.boxes.beliefs`.
        noise: ``naive`` (reports are true), ``aware`` (how often they are false is inferred) or a flip probability.
        reading: What it knows a false report to be: ``memoryless``, ``latched``, ``re-observed`` or ``integrated``.
            With ``outcomes`` it knows that outcomes are inverted and infers whether false positions stay, with
            ``positions`` that positions are.
    """

    exact: ClassVar[bool] = True
    heeds_panel = False

    prior: str = "single-parent"
    noise: str = "aware"
    reading: KnownReading = "outcomes"

    def __post_init__(self) -> None:
        if self.prior not in PRIORS:
            raise UnknownName("prior", self.prior, PRIORS)
        noise_model(self.noise, self.reading)

    def begin(self, view: View) -> Belief:
        """The prior over the interlocks of this number of joints."""
        return begin(interlocks(self.prior, view.joints), noise_model(self.noise, self.reading))

    def remember(self, view: View, memory: Belief, told: Told) -> Belief:
        """The posterior after a report."""
        numbers = _numbers(view)
        shifted = told.shifted
        positions = None if shifted is None else sum((shifted >> j & 1) << number for j, number in enumerate(numbers))
        return update(memory, numbers[told.joint], told.moved, positions, told.states_only)

    def probabilities(self, view: View, memory: Belief) -> tuple[float, ...]:
        """Equal for all joints that take the fewest expected steps."""
        best = best_joints(memory).tolist()
        return tuple(best[number] / sum(best) for number in _numbers(view))

    def claim(self, memory: Belief, told: Told) -> Outcome:
        """The more probable outcome; of two equal ones what it was told."""
        if memory.moved is None or abs(memory.moved - 0.5) < 1e-9:
            return told.outcome
        return "moved" if memory.moved > 0.5 else "blocked"


def _numbers(view: View) -> tuple[int, ...]:
    """The number of each listed joint in a belief: the target is 0, the others follow as listed."""
    return tuple(0 if j == view.target else j + (j < view.target) for j in range(view.joints))
