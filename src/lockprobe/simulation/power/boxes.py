"""Power of a study on several boxes: how often it shows, of boxes like these, that a condition changes success."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.paired_proportions import FEWEST, Pairs, difference_over_boxes
from lockprobe.statistics.proportions import ALPHA

TRIALS = (1, 2, 3, 5, 10, 20)
"""Numbers of trials on each box under each condition."""

STUDIES = 1000
"""Simulated studies of each size."""

DIFFICULTY_SD, EFFECT_SD = 0.15, 0.15
"""Standard deviation of success, and of its change, between boxes; chosen by eye."""


def power_over_boxes(
    success: Sequence[float],
    boxes: Sequence[int],
    trials: Sequence[int],
    *,
    effect_sd: float,
    seed: int,
    progress: Callable[[int, int], None],
) -> dict[tuple[int, int], float]:
    """How often a study on so many boxes detects the change, by the test of the report; trials share no luck.

    Args:
        success: The mean success over boxes under the control and under the condition.
        boxes: Numbers of boxes.
        trials: Numbers of trials on each box under each condition.
        effect_sd: Standard deviation of the change between boxes.
        seed: Of the simulation.
        progress: Called with the sizes done and all of them.

    Returns:
        Number of boxes and of trials on each -> the share of studies that detect it.
    """
    if len(success) != 2 or not all(0 <= share <= 1 for share in success):
        raise BadValue("success", ",".join(map(str, success)), "two shares: under the control, and under the condition")
    if min(boxes) < FEWEST:
        raise BadValue("boxes", min(boxes), f"at least {FEWEST}, for a sentence on boxes like these")
    power, every = dict[tuple[int, int], float](), [(k, n) for n in trials for k in boxes]
    for done, (k, n) in enumerate(every):
        progress(done, len(every))
        rng = generator(seed, "power", "boxes", k, n)
        base = success[0] + DIFFICULTY_SD * rng.standard_normal((STUDIES, k))
        change = success[1] - success[0] + effect_sd * rng.standard_normal((STUDIES, k))
        shares = np.clip(np.stack([base, base + change]), 0.0, 1.0)
        first, second = (rng.random((n, *shares.shape)) < shares).swapaxes(0, 1)
        lost, gained = ((one & ~other).sum(axis=0) * 1.0 for one, other in ((first, second), (second, first)))
        pairs = (Pairs(first=a, second=b, n=np.full(k, float(n))) for a, b in zip(lost, gained, strict=True))
        power[k, n] = sum(difference_over_boxes(one).interval_p < ALPHA for one in pairs) / STUDIES
    return power
