"""Simulated trials of an agent with known truth, as records or as columns.

The agent acts without immediate repeats, unless its world allows them. From the fourth step on, the box opens with
equal probability at every step, whatever the joint, so solved trials are shorter whether or not loops matter. The joint
that opens it counts as the target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.participant import participant_spec
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import group_of
from lockprobe.simulation.audit.simulated_agents import Design, World
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.trial.record import Decision, Step, Trial, TrialError
from lockprobe.trial.trial_name import TrialName

__all__ = ["BUDGET", "simulate", "simulate_columns", "simulate_outcomes", "simulate_study"]

BUDGET = 20
JOINTS = ("A", "B", "C", "D")
FIRST = 4
"""The earliest step at which the box opens: the optimum of chain-4."""

ESCAPE = 0.1
"""Chance per step to leave a cycle."""

PERIODS = (3, 4)

LOST_TRAP, LOST_SUCCESS = 0.4, 0.2
"""Trap and success of a lost agent, at every p."""

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class _SimulatedStudy:
    """A simulated study, one row per trial, by p, repetition and trial.

    Attributes:
        actions: Actions up to the budget, even after a trial has ended, shape (trials, BUDGET).
        solved: The step that solves the trial; 0 if none does or it breaks before; shape (trials,).
        broken: The step at which the trial breaks; 0 if it does not break; shape (trials,).
        played: Whether the trial was begun: nobody who has left plays on; shape (trials,).
    """

    actions: Integers
    solved: Integers
    broken: Integers
    played: NDArray[np.bool_]

    @property
    def length(self) -> Integers:
        """Steps played."""
        return np.where(self.broken > 0, self.broken - 1, np.where(self.solved > 0, self.solved, BUDGET))


def simulate(truth: World, design: Design, rng: np.random.Generator) -> list[Trial]:
    """One study of a simulated agent: its trials by p, repetition and trial."""
    played = _play(truth, design, rng)
    return [_trial(truth, design, played, place) for place in np.flatnonzero(played.played).tolist()]


def simulate_outcomes(truth: World, design: Design, rng: np.random.Generator) -> Outcomes:
    """The same study as columns: ``outcomes(simulate(...))`` without the records."""
    return simulate_columns(truth, design, rng)[0]


def simulate_columns(truth: World, design: Design, rng: np.random.Generator) -> tuple[Outcomes, Outcomes]:
    """The same with the trials that broke: ``outcomes(...)`` and ``broken_off(...)`` of the records."""
    return simulate_study(truth, design, rng)[:2]


def simulate_study(truth: World, design: Design, rng: np.random.Generator) -> tuple[Outcomes, Outcomes, list[Trial]]:
    """The same with the records at the lowest p."""
    played = _play(truth, design, rng)
    length, onset = played.length, onset_batch(played.actions)
    cluster = np.tile(np.arange(design.clusters), len(design.p))
    everything = Outcomes(
        dose=np.repeat(np.array(design.p, dtype=np.float64), design.clusters),
        repetition=cluster // design.trials + 1,
        trial=cluster % design.trials + 1,
        length=length,
        solved=played.solved > 0,
        onset=np.where(onset <= length, onset, 0),
        player=np.array([_player(truth, design, place) for place in range(len(cluster))] if truth.people else [], str),
    )
    lowest = [
        _trial(truth, design, played, place) for place in np.flatnonzero(played.played[: design.clusters]).tolist()
    ]
    return everything.at(played.played & (played.broken == 0)), everything.at(played.broken > 0), lowest


def _player(truth: World, design: Design, place: int) -> str:
    """The player of a trial: at each p every player has equally many consecutive trials."""
    condition, cluster = divmod(place, design.clusters)
    return participant_spec(f"{condition}-{cluster * truth.people // design.clusters}")


def _play(truth: World, design: Design, rng: np.random.Generator) -> _SimulatedStudy:
    if len(truth.success) != len(design.p) or len(truth.trap) != len(design.p):
        raise BadValue(
            f"world {truth.name}", f"{len(truth.success)} shares", f"one for each of {len(design.p)} flip rates"
        )
    conditions = np.repeat(np.arange(len(design.p)), design.clusters)
    luck = _luck(truth, len(design.p), design.clusters, rng)
    lost = rng.random(len(conditions)) < truth.lost
    actions = _actions(np.where(lost, LOST_TRAP, np.array(truth.trap)[conditions]), luck, repeats=truth.repeats)
    success = np.where(lost, LOST_SUCCESS, np.array(truth.success)[conditions])
    if truth.people:
        success = _by_player(success, truth, design, rng)
    solved = _solved_at(success, truth.harm, onset_batch(actions), luck[:, :, 2])
    if truth.slow:
        solved = _skewed(truth.slow, len(design.p), design.clusters, rng)
    broken = np.zeros_like(solved)
    if truth.breaks:
        failed = rng.random((len(solved), BUDGET)) < np.array(truth.breaks)[conditions, None]
        step = np.where(failed.any(axis=1), failed.argmax(axis=1) + 1, 0)
        broken = np.where((solved == 0) | (step <= solved), step, 0)
    played = _stayed(solved, truth, design, rng) if truth.leaves else np.ones(len(solved), dtype=np.bool_)
    return _SimulatedStudy(actions=actions, solved=np.where(broken > 0, 0, solved), broken=broken, played=played)


def _skewed(slow: float, conditions: int, clusters: int, rng: np.random.Generator) -> Integers:
    """The steps that solve trials of equal means: five to seven at the lowest p, else fewer or, in rare blocks, all."""
    steps = rng.integers(5, 8, size=(conditions, clusters))
    usual = (6 - slow * BUDGET) / (1 - slow)
    short = math.floor(usual) + (rng.random((conditions - 1, clusters)) < usual % 1)
    steps[1:] = np.where(rng.random(clusters) < slow, BUDGET, short)
    return steps.reshape(-1)


def _stayed(solved: Integers, truth: World, design: Design, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Whether each trial's player was still there: some leave after a trial that they have not solved."""
    leaves = (solved == 0) & (rng.random(len(solved)) < truth.leaves)
    names = [_player(truth, design, place) for place in range(len(solved))]
    gone: set[str] = set()
    stayed = np.empty(len(solved), dtype=np.bool_)
    for place, (name, left) in enumerate(zip(names, leaves.tolist(), strict=True)):
        stayed[place] = name not in gone
        if left:
            gone.add(name)
    return stayed


def _by_player(success: Floats, truth: World, design: Design, rng: np.random.Generator) -> Floats:
    """Each trial's probability of success, given its player's skill; the mean over players is as stated."""
    from scipy.special import ndtr, ndtri

    names = np.array([_player(truth, design, place) for place in range(len(success))])
    who = np.unique(names, return_inverse=True)[1]
    able = rng.standard_normal(int(who.max()) + 1)[who]
    found: Floats = ndtr((ndtri(success) + truth.likeness**0.5 * able) / (1 - truth.likeness) ** 0.5)
    return found


def _luck(truth: World, conditions: int, clusters: int, rng: np.random.Generator) -> Floats:
    """Uniform random numbers, shape (conditions x clusters, BUDGET, 3): for choices, cycles and solutions."""
    own = rng.random((conditions, clusters, BUDGET, 3))
    common = rng.random((clusters, BUDGET, 3))
    alike = rng.random(clusters) < truth.shared
    luck = np.where(alike[:, None, None], common, own)
    if truth.apart:
        luck[0] = own[0]
    return luck.reshape(-1, BUDGET, 3)


def _actions(trap: Floats, luck: Floats, *, repeats: bool) -> Integers:
    """The joints attempted, even after the box has opened, shape (trials, BUDGET)."""
    n = len(trap)
    actions = np.empty((n, BUDGET), dtype=np.int64)
    actions[:, 0] = luck[:, 0, 0] * len(JOINTS)
    period = np.zeros(n, dtype=np.int64)
    everyone = np.arange(n)
    for t in range(1, BUDGET):
        other = (luck[:, t, 0] * (len(JOINTS) - (not repeats))).astype(np.int64)
        fresh = other if repeats else other + (other >= actions[:, t - 1])
        # One number decides both ways: whether a cycle begins (and its period), or whether it ends.
        chance = luck[:, t, 1]
        begun = np.where(chance < trap / 2, PERIODS[0], PERIODS[1])
        period = np.where(period > 0, np.where(chance < ESCAPE, 0, period), np.where(chance < trap, begun, 0))
        period = np.where(period > t, 0, period)
        actions[:, t] = np.where(period > 0, actions[everyone, np.maximum(t - period, 0)], fresh)
    return actions


def _solved_at(success: Floats, harm: float, onset: Integers, luck: Floats) -> Integers:
    """The step at which each trial is solved, 0 if it is not. A loop completed at t has its effect from t + 1 on."""
    steps = np.arange(1, BUDGET + 1)
    hazard = (1 - (1 - success) ** (1 / (BUDGET - FIRST + 1)))[:, None] * (steps >= FIRST)
    looped = (onset[:, None] > 0) & (onset[:, None] < steps)
    opened = luck < np.where(looped, harm, 1.0) * hazard
    return np.where(opened.any(axis=1), opened.argmax(axis=1) + 1, 0)


_DECISIONS = tuple(Decision(joint=joint) for joint in JOINTS)


def _trial(truth: World, design: Design, played: _SimulatedStudy, place: int) -> Trial:
    """The record of one trial. The joint attempted last opens the box, so it is the target."""
    condition, cluster = divmod(place, design.clusters)
    repetition, trial = (number + 1 for number in divmod(cluster, design.trials))
    actions = played.actions[place, : played.length[place]].tolist()
    solved, broken = bool(played.solved[place]), int(played.broken[place])
    last = len(actions) - 1
    told = design.conditions[condition]
    agent = _player(truth, design, place) if truth.people else f"simulated:{truth.name}"
    name = TrialName(study="audit", agent=group_of(agent), condition=told.label, repetition=repetition, trial=trial)
    return Trial(
        key=str(name),
        study=name.study,
        agent=agent,
        facts={},
        box="clock",
        condition=told.label,
        specs=told.specs,
        doses=told.doses,
        modality=told.modality,
        channels=(),
        repetition=repetition,
        trial=trial,
        seed=0,
        budget=BUDGET,
        joints=JOINTS,
        labels=JOINTS,
        listing=JOINTS,
        target=JOINTS[actions[-1]] if actions else JOINTS[0],
        opening="",
        steps=tuple(
            Step(
                step=i + 1,
                state="0000",
                joint=JOINTS[action],
                moved=solved and i == last,
                told_moved=solved and i == last,
                told_state=None,
                told="",
                decision=_DECISIONS[action],
            )
            for i, action in enumerate(actions)
        ),
        ending="error" if broken else "solved" if solved else "budget",
        error=TrialError(boundary="model", message="simulated", step=broken) if broken else None,
    )
