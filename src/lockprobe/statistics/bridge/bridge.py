"""Do misreadings of pictures act as false reports in words do? The analysis of the study ``bridge``.

The paper likens misreadings of pictures (Sec. 3.1) to random flips (Sec. 3.2), as "evidence for a plausible mechanism,
not a direct explanation of the physical results". Here an agent plays in words, in pictures, and in words with its own
misreadings of the pictures told as false reports, in trials of equal luck. The difference between pictures and words is
one of steps, in which an unsolved trial counts with its whole budget. The share of it that is there again in words with
the misreadings told is what they account for, as false reports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, block_mean
from lockprobe.statistics.bridge.arms import ARMS, PICTURES, WORDS
from lockprobe.statistics.bridge.share import Share, Verdict, share_of
from lockprobe.statistics.confusion import Confusion, confusion
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion
from lockprobe.statistics.rare_long_trials import rare_block
from lockprobe.trial.record import Trial

__all__ = ["Bridge", "BridgeArm", "bridge"]

_FEWEST = 2
"""Fewest blocks with a trial in words, in pictures and with the misreadings replayed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeArm:
    """One arm.

    Attributes:
        arm: As in :mod:`lockprobe.statistics.bridge.arms`.
        condition: The name of the condition in the study.
        success: Share solved.
        steps: Mean steps; an unsolved trial counts with its whole budget.
        told: False reports, in all its trials; of pictures the misreadings.
        change: Steps minus steps in words, over blocks; None for the words.
        share: The share of this change in that of the pictures; None for words and pictures, and unless pictures are
            shown to change steps and the agent says what its actions did.
    """

    arm: str
    condition: str
    success: Proportion
    steps: float
    told: int
    change: BlockMean | None = None
    share: Share | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Bridge:
    """The bridge of one agent.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: The pictures.
        arms: Words, pictures, and the arms that were played.
        misread: How the agent misread the pictures.
        agents: Number of agents (and pictures) that are judged together. Intervals and P values of the change by
            pictures and of the replayed share are corrected for it (Bonferroni), those of the other arms for their
            number too.
    """

    agent: str
    modality: str
    arms: tuple[BridgeArm, ...]
    misread: Confusion
    agents: int = 1

    def arm(self, name: str) -> BridgeArm:
        """An arm that was played."""
        return next(one for one in self.arms if one.arm == name)

    @property
    def total(self) -> BlockMean:
        """Steps in pictures minus steps in words."""
        change = self.arm(PICTURES).change
        assert change is not None
        return change

    @property
    def differs(self) -> bool:
        """Whether pictures are shown to change the number of steps."""
        return _is_shown(self.total, self.agents)

    def verdict(self, arm: str = "replayed") -> Verdict | Literal["nothing said", "no difference", "nothing misread"]:
        """What an arm accounts for of the difference between pictures and words."""
        if not self.misread.claims:
            return "nothing said"
        if not self.differs:
            return "no difference"
        if not self.misread.misread:
            return "nothing misread"
        share = self.arm(arm).share
        return share.verdict if share is not None else "not decided"


def bridge(trials: Mapping[str, Sequence[Trial]], arms: Mapping[str, str], *, agents: int = 1) -> Bridge | None:
    """Analyse one bridge of one agent.

    Args:
        trials: Condition -> the agent's trials.
        arms: Arm -> its condition, as :func:`lockprobe.statistics.bridge.arms.bridges_of` finds them.
        agents: Number of agents (and pictures) that are judged together.

    Returns:
        None unless two blocks or more have trials in words, in pictures and with the misreadings replayed.
    """
    order = [arm for arm in (WORDS, PICTURES, *ARMS) if arm in arms]
    played = {arm: own for arm in order if (own := ended(trials.get(arms[arm], ())))}
    blocks = {arm: {(one.repetition, one.trial): len(one.steps) for one in own} for arm, own in played.items()}
    needed = [blocks.get(arm, {}) for arm in (WORDS, PICTURES, "replayed")]
    if len(set.intersection(*map(set, needed))) < _FEWEST:
        return None
    first = played[PICTURES][0]
    pictures = _change(blocks, PICTURES, first.budget, agents)
    shown, misread = _is_shown(pictures, agents), confusion(played[PICTURES])
    others = len([arm for arm in played if arm in ARMS and arm != "replayed"])
    made = []
    for arm, own in played.items():
        looks = agents * (others if arm in ARMS and arm != "replayed" else 1)
        change = pictures if arm == PICTURES else None if arm == WORDS else _change(blocks, arm, first.budget, looks)
        made.append(
            BridgeArm(
                arm=arm,
                condition=arms[arm],
                success=proportion(sum(one.solved for one in own), len(own)),
                steps=float(np.mean(list(blocks[arm].values()))),
                told=sum(map(_misread if arm == PICTURES else _false_reports, own)),
                change=change,
                share=_share(blocks, arm, looks) if shown and arm in ARMS and misread.claims else None,
            )
        )
    return Bridge(
        agent=first.group,
        modality=first.modality,
        arms=tuple(made),
        misread=misread,
        agents=agents,
    )


_Blocks = Mapping[str, Mapping[tuple[int, int], int]]
"""Arm -> block -> steps."""


def _paired(blocks: _Blocks, *arms: str) -> list[Array]:
    """The steps of arms in the blocks that all of them have, each of shape (blocks,)."""
    both = sorted(set.intersection(*(set(blocks[arm]) for arm in arms)))
    return [np.array([blocks[arm][block] for block in both], dtype=np.float64) for arm in arms]


def _change(blocks: _Blocks, arm: str, budget: int, looks: int) -> BlockMean:
    words, own = _paired(blocks, WORDS, arm)
    if not len(words):
        return block_mean(np.empty((0, 1)))
    shortest = float(min(words.min(), own.min()))
    rare = rare_block(float(words.mean()), float(own.mean()), float(budget), shortest)
    return block_mean((own - words)[:, None], unit=float(budget), choices=looks, rare=rare)


def _share(blocks: _Blocks, arm: str, looks: int) -> Share | None:
    words, pictures, own = _paired(blocks, WORDS, PICTURES, arm)
    return share_of(own - words, pictures - words, 1 - ALPHA / looks) if len(words) >= _FEWEST else None


def _is_shown(change: BlockMean, agents: int) -> bool:
    return change.clear and change.p_value is not None and change.p_value < ALPHA / agents


def _misread(trial: Trial) -> int:
    return sum(claim.false_belief for claim in claims(trial))


def _false_reports(trial: Trial) -> int:
    return sum(step.told_falsely for step in trial.steps[:-1])
