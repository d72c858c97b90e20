"""Columns of trials for tests of success over p, made of arrays of solved or not."""

from dataclasses import replace

import numpy as np

from lockprobe.statistics.outcomes import Outcomes

TRUTH = np.array([7, 12, 16, 19, 20, 18, 15]) / 30
"""A rise and a fall like the paper's."""


def study(solved, p=None):
    """Outcomes from an array (p, repetition, trial) of solved or not."""
    solved = np.asarray(solved, dtype=bool)
    i, r, t = np.indices(solved.shape).reshape(3, -1)
    p = np.arange(len(solved)) / max(10, len(solved)) if p is None else np.asarray(p)
    return replace(columns(p[i], t + 1, solved=solved.reshape(-1)), repetition=r + 1)


def columns(dose, trial, *, length=20, solved=None, onset=0, budget=20):
    """Outcomes of one repetition; without more, a trial shorter than 20 steps is solved, and none loops."""
    n, length = len(dose), np.broadcast_to(np.asarray(length, dtype=np.int64), len(dose))
    return Outcomes(
        dose=np.asarray(dose, dtype=np.float64),
        repetition=np.ones(n, dtype=np.int64),
        trial=np.asarray(trial, dtype=np.int64),
        length=length,
        solved=length < 20 if solved is None else np.asarray(solved, dtype=bool),
        onset=np.broadcast_to(np.asarray(onset, dtype=np.int64), n),
        budget=budget,
    )


def drawn(rng, success=0.5, shape=(7, 3, 10), shared=0.0):
    """Solved or not: with the given chance all values of p of a cluster share one draw, else each has its own."""
    luck = np.where(rng.random((1, *shape[1:])) < shared, rng.random((1, *shape[1:])), rng.random(shape))
    return luck < np.broadcast_to(success, shape[:1])[:, None, None]


def unequal_luck(rng):
    """Half solved at every p, alike at all p but the lowest: p changes which trials are solved, and not how many."""
    solved = rng.random((7, 1, 30)) < 0.5
    solved[1:] = solved[1]
    return solved


def people(rng, per_p, boxes, likeness, p=7):
    """Columns of people each of whom plays boxes at one p only, alike within a person by a share of the variance."""

    able = np.repeat(rng.standard_normal((p, per_p)), boxes, axis=1)
    hidden = likeness**0.5 * able + (1 - likeness) ** 0.5 * rng.standard_normal((p, per_p * boxes))
    columns = study((hidden < 0)[:, None])
    who = [f"{place}-{number // boxes}" for place in range(p) for number in range(per_p * boxes)]
    return replace(columns, player=np.array(who))


def left_after_failures(rng, people=60, boxes=6, leaves=0.5, likeness=0.5):
    """Who played each trial, and whether it was solved; people are unequally able, and some leave after a failure."""
    from scipy.stats import norm

    able = rng.standard_normal(people)
    chance = norm.cdf(likeness**0.5 * able / (1 - likeness) ** 0.5)
    played = []
    for i in range(people):
        for _ in range(boxes):
            played.append((i, bool(rng.random() < chance[i])))
            if not played[-1][1] and rng.random() < leaves:
                break
    return np.array(played).T


def smallest(differences):
    """The smallest P value; None without a difference."""
    return min((one.p_value for one in differences), default=None)


def rng(seed=1):
    return np.random.default_rng(seed)
