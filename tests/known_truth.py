"""Studies of simulated agents whose truth is known (worlds), as columns: error rates are held with them."""

from dataclasses import dataclass, replace

import numpy as np

from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes

P, BUDGET, JOINTS, FIRST = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6), 20, 4, 4


@dataclass(frozen=True, kw_only=True)
class Known:
    """What is true of an agent that acts without immediate repeats, and of its studies.

    From the fourth step on the box opens with equal probability at every step, whatever the joint. ``trap``: chance per
    step of falling into a cycle of three or four actions. ``shared``: share of trials with the same luck at every p;
    ``apart``: the lowest p has another. ``people``: who play at each p, each at one, unequally good by ``likeness``.
    ``breaks``: chance per step of an error at the highest p. ``slow``: share of blocks that take the whole budget at
    every p but the lowest, with equal means. ``truths``: questions whose answer is yes.
    """

    success: tuple[float, ...] = (0.5,) * 7
    trap: tuple[float, ...] = (0.0,) * 7
    truths: frozenset = frozenset()
    shared: float = 0.0
    apart: bool = False
    people: int = 0
    likeness: float = 0.0
    breaks: float = 0.0
    slow: float = 0.0


FASTER, SHAPED = frozenset({"success", "speed"}), frozenset({"success", "speed", "shape"})

WORLDS = {
    "loops-irrelevant": Known(success=(0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5), truths=SHAPED),
    "loop-trapped": Known(
        success=(0.85,) * 7, trap=(0.5, 0.25, 0.12, 0.06, 0.03, 0.03, 0.03), truths=frozenset({"looping"})
    ),
    "no-effect": Known(),
    "shared-luck": Known(shared=0.5),
    "unequal-luck": Known(shared=1.0, apart=True),
    "people": Known(people=6, likeness=0.5),
    "skewed-steps": Known(success=(1.0,) * 7, slow=0.05),
    "broken-trials": Known(breaks=0.08),
    "saturating": Known(success=(0.23, 0.45, 0.57, 0.63, 0.66, 0.67, 0.67), truths=FASTER),
    "inverted-u": Known(success=(0.2, 0.55, 0.8, 0.9, 0.8, 0.55, 0.2), truths=SHAPED),
    "loops-return": Known(trap=(0.5, 0.25, 0.1, 0.03, 0.1, 0.25, 0.5), truths=frozenset({"looping", "looping again"})),
}


def _actions(trap, luck):
    """The joints attempted, even after the box has opened, shape (trials, BUDGET)."""
    n = len(trap)
    actions = np.empty((n, BUDGET), dtype=np.int64)
    actions[:, 0] = luck[:, 0, 0] * JOINTS
    period = np.zeros(n, dtype=np.int64)
    for t in range(1, BUDGET):
        other = (luck[:, t, 0] * (JOINTS - 1)).astype(np.int64)
        fresh = other + (other >= actions[:, t - 1])
        chance = luck[:, t, 1]  # decides both: whether a cycle begins (and its period), or whether it ends
        begun = np.where(chance < trap / 2, 3, 4)
        period = np.where(period > 0, np.where(chance < 0.1, 0, period), np.where(chance < trap, begun, 0))
        period = np.where(period > t, 0, period)
        actions[:, t] = np.where(period > 0, actions[np.arange(n), np.maximum(t - period, 0)], fresh)
    return actions


def _solved_at(success, luck):
    """The step at which each trial is solved, 0 if it is not."""
    opens = (1 - (1 - success) ** (1 / (BUDGET - FIRST + 1)))[:, None] * (np.arange(1, BUDGET + 1) >= FIRST)
    opened = luck < opens
    return np.where(opened.any(axis=1), opened.argmax(axis=1) + 1, 0)


def simulated(name, rng, *, p=P, repetitions=3, trials=10, **changed):
    """The trials of one study, of the size of the paper's flip study (Sec. 3.2) if no other is given."""
    truth, n, clusters = replace(WORLDS[name], **changed), len(p), repetitions * trials
    luck = rng.random((n, clusters, BUDGET, 3))
    alike = rng.random(clusters) < truth.shared
    luck[truth.apart :, alike] = rng.random((clusters, BUDGET, 3))[alike]
    luck = luck.reshape(-1, BUDGET, 3)
    success = np.repeat(truth.success, clusters)
    who = np.arange(n * clusters) * truth.people // clusters
    if truth.people:
        from scipy.special import ndtr, ndtri

        able = rng.standard_normal(n * truth.people)[who] * truth.likeness**0.5
        success = ndtr((ndtri(success) + able) / (1 - truth.likeness) ** 0.5)
    actions = _actions(np.repeat(truth.trap, clusters), luck)
    onset = onset_batch(actions)
    solved = _solved_at(success, luck[:, :, 2])
    if truth.slow:
        solved = _skewed(truth.slow, n, clusters, rng)
    failed = rng.random((n * clusters, BUDGET)) < np.repeat([0.0] * (n - 1) + [truth.breaks], clusters)[:, None]
    fault = np.where(failed.any(axis=1), failed.argmax(axis=1) + 1, BUDGET + 1)
    broke = (fault <= BUDGET) & ((solved == 0) | (fault <= solved))
    length = np.where(broke, fault - 1, np.where(solved > 0, solved, BUDGET))
    cluster = np.tile(np.arange(clusters), n)
    return Outcomes(
        dose=np.repeat(np.array(p), clusters),
        repetition=cluster // trials + 1,
        trial=cluster % trials + 1,
        length=length,
        solved=(solved > 0) & ~broke,
        onset=np.where(onset <= length, onset, 0),
        broke=broke,
        player=np.array([f"participant:{one}" for one in who] if truth.people else [], str),
        budget=BUDGET,
    )


def _skewed(slow, n, clusters, rng):
    """Five to seven steps at the lowest p, else fewer or, in rare blocks, all: of equal means."""
    steps = rng.integers(5, 8, size=(n, clusters))
    usual = (6 - slow * BUDGET) / (1 - slow)
    short = int(usual) + (rng.random((n - 1, clusters)) < usual % 1)
    steps[1:] = np.where(rng.random(clusters) < slow, BUDGET, short)
    return steps.reshape(-1)
