"""Episodes whose truth is known: tasks that differ, luck that both conditions share, loops that may tie to failure."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from lockprobe.interfaces.episodes.frame import Episodes, combined, position


def episodes(agent, condition, task, seed, solved, *, steps=None, actions=(), score=None):
    """Episodes of columns of whole numbers; a seed of -1 is none."""
    columns = [np.asarray(column, dtype=np.int64) for column in (agent, condition, task, seed)]
    agent, condition, task, seed = columns
    n, luck = len(agent), np.where(seed < 0, -1, combined(task, seed + 1))
    names = [
        [f"{what} {i}" for i in range(column.max() + 1)]
        for what, column in zip(("agent", "condition", "task"), columns[:3], strict=True)
    ]
    unknown = np.full(n, np.nan)
    return Episodes(
        agents=names[0], conditions=names[1], tasks=names[2], agent=agent, condition=condition, task=task, luck=luck,
        rank=position(combined(agent, condition, luck + 1)), solved=np.asarray(solved, dtype=float), actions=actions,
        steps=unknown if steps is None else np.asarray(steps, dtype=float), score=unknown if score is None else score,
    )  # fmt: skip


def world(rng, *, tasks=8, seeds=6, agents=2, matched=0.7, effect=0.0, spread=0.25, shared=0.8, seeded=True):
    """Two conditions on tasks that differ in success (``spread``) and, by half of it, in the effect, whose mean is known.

    A share of ``matched`` seeds is played under both conditions, others under one; of equal luck a share of ``shared``
    draws is equal.
    """
    level = np.clip(0.5 + spread * rng.standard_normal(tasks), 0.05, 0.95)
    change = effect + (spread / 2 * rng.standard_normal(tasks) if effect == 0 else 0)
    a, c, t, s = (column.ravel() for column in np.meshgrid(*map(np.arange, (agents, 2, tasks, seeds)), indexing="ij"))
    s = np.where((c == 1) & (s >= matched * seeds), s + seeds, s)
    common, own = rng.random((tasks, 2 * seeds)), rng.random(len(a))
    draw = np.where(rng.random((tasks, 2 * seeds)) < shared, common, np.nan)[t, s]
    chance = np.clip(level[t] + c * np.broadcast_to(change, tasks)[t], 0, 1)
    return episodes(a, c, t, s if seeded else np.full(len(s), -1), np.where(np.isnan(draw), own, draw) < chance)


def looping(rng, n=400, budget=60, habit=0.3, trap=0.0):
    """Episodes on 8 tasks that are solved at random at every step, by agents that repeat what they did three steps ago.

    With a ``trap`` an episode that has looped is solved less often by this share.
    """
    made, solved = [], np.zeros(n, dtype=bool)
    quick = rng.choice([0.004, 0.05], n)  # some are long, and long ones fail
    for i in range(n):
        did, looped, first = [], False, {}
        while len(did) < budget and not solved[i]:
            again = len(did) > 2 and rng.random() < habit
            did.append(did[-3] if again else str(rng.integers(6)))
            looped |= len(did) - first.setdefault(tuple(did[-3:]), len(did)) >= 3 and len(did) > 3
            solved[i] = rng.random() < quick[i] * (1 - trap * looped)
        made.append(tuple(did))
    steps = [len(did) for did in made]
    return episodes(np.zeros(n), np.zeros(n), np.arange(n) % 8, np.arange(n), solved, steps=steps, actions=made)


def made_by_example(path, *sizes):
    """The table that the example of the documentation makes, of so many tasks, seeds, and seeds that do not match."""
    example = Path(__file__).parents[1] / "examples" / "episodes.py"
    subprocess.run([sys.executable, example, path, *(sizes or ("8", "6", "2"))], check=True)
    return path
