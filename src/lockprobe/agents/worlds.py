"""Agents of known mechanism, to test causal analyses on: whether false reports change success, and through what.

Each is a :class:`Policy`, so its success under every condition, and with it the true effect, is exact
(:func:`lockprobe.propagate`). All look only at what they are told.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from lockprobe.agents.cognitive import CHARACTERS, SoftmaxMemory
from lockprobe.agents.hearing import Hears, Jolted
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.loop_breakers import AnyFalsehood, FormByLength, LoopBreaker, Novelty, Sceptic
from lockprobe.agents.policy import Policy, Told, View, evenly
from lockprobe.agents.strategies import RandomNoRepeat
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_probability
from lockprobe.trial.record import Fact

__all__ = ["WORLDS", "Believer", "Failures", "Half", "Halves", "LostHalf", "LostPair"]


@dataclass(frozen=True, slots=True)
class Failures:
    """The memory of a believer.

    Attributes:
        failed: Joints that failed since the last perceived move, bit j for joint j.
        due: Whether something has just moved, so that the target is due.
    """

    failed: int = 0
    due: bool = False


@dataclass(frozen=True, kw_only=True)
class Believer(Policy[Failures]):
    """It believes every report: the target after every move, else any joint that has not failed since.

    It takes a corrected report as corrected and learns nothing from one that is withheld.

    Attributes:
        lapse: Probability of any joint instead, [0, 1].

    Raises:
        BadValue: If ``lapse`` is no probability.
    """

    lapse: float = 0.0

    def __post_init__(self) -> None:
        check_probability("lapse", self.lapse)

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its parameters."""
        return asdict(self)

    def begin(self, view: View) -> Failures:
        """Nothing has failed."""
        return Failures()

    def remember(self, view: View, memory: Failures, told: Told) -> Failures:
        """A move makes all joints worth another attempt."""
        return Failures(0, due=True) if told.moved else Failures(memory.failed | 1 << told.joint)

    def probabilities(self, view: View, memory: Failures) -> tuple[float, ...]:
        """The target when it is due, else equal for all that have not failed; lapses are equal for all."""
        open_ = [joint for joint in range(view.joints) if not memory.failed >> joint & 1]
        meant = [view.target] if memory.due else open_ or list(range(view.joints))
        return evenly(meant, view, self.lapse)


@dataclass(frozen=True, slots=True)
class LostPair:
    """The evidence so far on whether a trial is lost.

    Attributes:
        pair: The first two joints attempted.
        steps: How many attempts so far agree with a cycle over this pair; -1 once one did not.
    """

    pair: tuple[int, ...] = ()
    steps: int = 0


@dataclass(frozen=True, kw_only=True)
class LostHalf(Policy[LostPair]):
    """In half of all trials it cycles over two joints that are not the target; in the others it acts at random.

    Reports mean nothing to it. Which half a trial belongs to shows in its choices alone: their probabilities are those
    of the mixture, given the choices so far.
    """

    looks = False

    def begin(self, view: View) -> LostPair:
        """Nothing was chosen.

        Raises:
            BadValue: If the box has fewer than three joints.
        """
        if view.joints < 3:
            raise BadValue("box", f"{view.joints} joints", "at least three joints: the target and two to cycle over")
        return LostPair()

    def remember(self, view: View, memory: LostPair, told: Told) -> LostPair:
        """The choice counts, not the report."""
        return self.remember_silence(view, memory, told.joint)

    def remember_silence(self, view: View, memory: LostPair, joint: int) -> LostPair:
        """Whether the choice agrees with a cycle over two joints that are not the target."""
        if memory.steps < 0:
            return memory
        fits = (
            joint != view.target and joint not in memory.pair
            if memory.steps < 2
            else (joint == memory.pair[memory.steps % 2])
        )
        if not fits:
            return LostPair(steps=-1)
        return LostPair((*memory.pair, joint) if memory.steps < 2 else memory.pair, memory.steps + 1)

    def probabilities(self, view: View, memory: LostPair) -> tuple[float, ...]:
        """Those of the mixture of both halves, given the choices so far."""
        joints, others = view.joints, view.joints - 1
        lost = 0.0
        if memory.steps >= 0:
            of_lost = [1.0, 1 / others, 1 / (others * (others - 1))][min(memory.steps, 2)]
            lost = of_lost / (of_lost + joints**-memory.steps)
        return tuple((1 - lost) / joints + lost * self._next(view, memory, joint) for joint in range(joints))

    def _next(self, view: View, memory: LostPair, joint: int) -> float:
        """The probability of a joint in a trial that is lost."""
        if memory.steps >= 2:
            return float(joint == memory.pair[memory.steps % 2])
        return 0.0 if joint == view.target or joint in memory.pair else 1 / (view.joints - 1 - memory.steps)


@dataclass(frozen=True, slots=True)
class Half:
    """The memory of an agent of two halves.

    Attributes:
        kept: The memories of both policies; None for the one that does not act.
        first: The joint attempted first, until the second attempt decides; -1 else.
        acts: Which policy acts: 0 or 1; -1 while it is not decided.
    """

    kept: tuple[Any, Any]
    first: int = -1
    acts: int = -1


@dataclass(frozen=True, kw_only=True)
class Halves(Policy[Half]):
    """One policy in half of all trials, and another in the other half.

    It attempts any joint first. In half of all trials it then attempts the same joint again, and the first policy acts
    from there on; else it attempts any other, and the second policy acts. Both have heard all reports by then.

    Attributes:
        policies: Both.
    """

    heeds_remarks = True

    policies: tuple[Policy[Any], Policy[Any]]

    def begin(self, view: View) -> Half:
        """Nothing is decided."""
        one, other = (policy.begin(view) for policy in self.policies)
        return Half((one, other))

    def remember(self, view: View, memory: Half, told: Told) -> Half:
        """As the policies that may act."""
        return self._after(memory, told.joint, lambda policy, kept: policy.remember(view, kept, told))

    def remember_silence(self, view: View, memory: Half, joint: int) -> Half:
        """As the policies that may act."""
        return self._after(memory, joint, lambda policy, kept: policy.remember_silence(view, kept, joint))

    def _after(self, memory: Half, joint: int, heard: Callable[[Policy[Any], Any], Any]) -> Half:
        acts = int(joint != memory.first) if memory.first >= 0 else memory.acts
        one, other = (
            heard(policy, kept) if acts in (-1, number) else None
            for number, (policy, kept) in enumerate(zip(self.policies, memory.kept, strict=True))
        )
        return Half((one, other), joint if acts < 0 else -1, acts)

    def probabilities(self, view: View, memory: Half) -> tuple[float, ...]:
        """Any joint first, the same again in half of all trials, then those of the policy that acts."""
        if memory.acts >= 0:
            return self.policies[memory.acts].probabilities(view, memory.kept[memory.acts])
        if memory.first < 0:
            return evenly(range(view.joints), view)
        others = evenly([joint for joint in range(view.joints) if joint != memory.first], view)
        return tuple(share / 2 if share else 0.5 for share in others)


def _perseverant() -> SoftmaxMemory:
    """Lies help it much, through what they say."""
    return SoftmaxMemory(**CHARACTERS["perseverant"])


WORLDS: Mapping[str, Any] = {
    "loop-breaker": LoopBreaker,
    "novelty": Novelty,
    "form-by-length": FormByLength,
    "sceptic": Sceptic,
    "any-falsehood": AnyFalsehood,
    "first-believer": lambda: Hears(policy=_perseverant(), believes="first"),
    "last-believer": _perseverant,
    "agreed-believer": lambda: Hears(policy=_perseverant(), believes="agreed"),
    "plain-believer": lambda: Hears(policy=_perseverant(), believes="neither"),
    "correction-jolt": lambda: Jolted(policy=_perseverant()),
    "half-and-half": lambda: Halves(policies=(LoopBreaker(), Hears(policy=_perseverant(), believes="first"))),
    "information": lambda: Believer(lapse=0.1),
    "information-hurts": HumanInspired,
    "perseverant": lambda: SoftmaxMemory(stay=2.2),
    "careful-believer": Believer,
    "irrelevant": RandomNoRepeat,
    "lost-half": LostHalf,
}
"""The worlds by name, as in ``world:loop-breaker``."""
