"""Power of a study on several boxes: how often it shows, of boxes like these, that a condition changes success."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.paired_proportions import FEWEST, Pairs, difference_over_boxes
from lockprobe.statistics.proportions import ALPHA

BOXES, TRIALS = (5, 10, 20), (1, 2, 3, 5, 10, 20)
"""Numbers of boxes, and of trials on each under each condition, whose power is measured."""

DIFFICULTY_SD, EFFECT_SD = 0.15, 0.15
"""Standard deviation of success, and of its change, between boxes; chosen by eye."""


def power_over_boxes(
    success: Sequence[float],
    *,
    boxes: Sequence[int] = BOXES,
    trials: Sequence[int] = TRIALS,
    effect_sd: float = EFFECT_SD,
    studies: int = 1000,
    seed: int = 1,
    progress: Callable[[int, int], None] = lambda done, every: None,
) -> dict[tuple[int, int], float]:
    """How often a study on so many boxes detects the change, by the test of the report; trials share no luck.

    Args:
        success: The mean success over boxes under the control and under the condition.
        boxes: Numbers of boxes.
        trials: Numbers of trials on each box under each condition.
        effect_sd: Standard deviation of the change between boxes.
        studies: Simulated studies of each kind.
        seed: Of the simulation.
        progress: Called with the kinds done and all of them.

    Returns:
        Number of boxes and of trials on each -> the share of studies that detect it.
    """
    if len(success) != 2 or not all(0 <= share <= 1 for share in success):
        raise BadValue("success", ",".join(map(str, success)), "two shares: under the control, and under the condition")
    if min(boxes) < FEWEST:
        raise BadValue("boxes", min(boxes), f"at least {FEWEST}, for a sentence on boxes like these")
    power = dict.fromkeys(((k, n) for n in trials for k in boxes), 0.0)
    for done, (k, n) in enumerate(power):
        progress(done, len(power))
        rng = generator(seed, "power", "boxes", k, n)
        base = success[0] + DIFFICULTY_SD * rng.standard_normal((studies, k))
        change = success[1] - success[0] + effect_sd * rng.standard_normal((studies, k))
        shares = np.clip(np.stack([base, base + change]), 0.0, 1.0)
        solved = rng.random((n, *shares.shape)) < shares
        first, second = solved[:, 0], solved[:, 1]
        only, gained = ((one & ~other).sum(axis=0) * 1.0 for one, other in ((first, second), (second, first)))
        tested = (
            difference_over_boxes(Pairs(first=one, second=two, n=np.full(k, float(n))))
            for one, two in zip(only, gained, strict=True)
        )
        power[k, n] = sum(one.interval_p < ALPHA for one in tested) / studies
    progress(len(power), len(power))
    return power
