"""Blocks of luck played by an agent: one trial under each of several conditions, of equal repetition and number."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.workers import THIS_PROCESS, Pool
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition

BATCH = 250
"""Blocks that a process plays before it reports."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """What is played.

    Attributes:
        study: The study whose settings and seed blocks have, whatever number of trials it asks for.
        agent: Spec of the agent; it costs nothing to ask.
        conditions: The conditions of every block.
    """

    study: Study
    agent: str
    conditions: tuple[Condition, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _BlockRange:
    """Some blocks, by their numbers from 1: the work of one job."""

    of: Played
    numbers: range


def played_blocks(
    asked: Sequence[Played],
    blocks: int,
    *,
    workers: Pool = THIS_PROCESS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[NDArray[np.bool_]]:
    """Play blocks of luck.

    Args:
        asked: What is played.
        blocks: Number of blocks of each.
        workers: The pool of processes that plays them; their number changes nothing.
        progress: Called with the number of blocks played and their total.

    Returns:
        For each of ``asked``, whether each trial was solved, shape (blocks, conditions).
    """
    jobs = [
        _BlockRange(of=one, numbers=range(1, blocks + 1)[first : first + BATCH])
        for one in asked
        for first in range(0, blocks, BATCH)
    ]
    parts: list[NDArray[np.bool_]] = []
    for part in workers.map(_batch, jobs):
        parts.append(part)
        progress(sum(map(len, parts)), blocks * len(asked))
    each = -(-blocks // BATCH)
    return [np.concatenate(parts[first : first + each]) for first in range(0, len(parts), each)]


def _batch(job: _BlockRange) -> NDArray[np.bool_]:
    return asyncio.run(_play(job))


async def _play(job: _BlockRange) -> NDArray[np.bool_]:
    player = resolve(job.of.agent).make()
    found = np.zeros((len(job.numbers), len(job.of.conditions)), dtype=np.bool_)
    for i, number in enumerate(job.numbers):
        for j, condition in enumerate(job.of.conditions):
            plan = job.of.study.plan(job.of.agent, condition, 1, number)
            found[i, j] = (await play_timed(plan, player))[0].solved
    return found
