"""The kernel: boxes and policies as arrays with one row a trial, for as many trials as asked.

It is the loop of :mod:`lockprobe.trial.loop` on arrays, for a box that follows its rules and reports on which nothing
but one flip acts. Positions are numbers with one bit a joint: configurations in the order of the panel, what is told in
the order in which a trial lists the joints. Trial i of a population equals that of :func:`lockprobe.run_trial`, alone
or among a million, since luck has addresses (:mod:`lockprobe.trial.luck`).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import Policy, Told, View, running_sums
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.boxes.solve import Space, space_of
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import blind
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.interventions.modality import shown
from lockprobe.interventions.words import Tell, TextChannel
from lockprobe.statistics.loops import onset_batch
from lockprobe.trial.labels import drawn_orders
from lockprobe.trial.luck import numbers
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import LONGEST_TRIAL, STATES, Outcome
from lockprobe.trial.source import source_of

MOST_STEPS = 1_000_000_000
"""Three bytes each are kept."""

_MOST = 100_000
"""Minds that are kept for later trials: those of some policies are never the same twice."""

PIECE = 8_192
"""Trials played at once: their numbers fit into the processor's cache."""


Whole = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class World:
    """A box with its state space, what its reports tell, and the flip that can invert each; ``budget`` is in steps."""

    box: Lockbox
    space: Space
    flip: OutcomeFlip
    budget: int
    tell: Tell = "both"

    @property
    def states_only(self) -> bool:
        """Whether positions are told and no outcomes."""
        return self.tell == "state"

    def view(self, order: tuple[int, ...], *, panel: bool = True) -> View:
        """A policy's view of the task, given the order in which joints (by index in panel order) are listed.

        Without ``panel`` the view leaves out where the joints lie.
        """
        places = tuple(self.box.joints[joint].place for joint in order) if panel else ()
        return View(joints=len(order), target=order.index(self.space.target), places=places)


def world_of(
    box: str | Path | Lockbox, flip: FlipKind | OutcomeFlip, p: float, modality: str | None, max_steps: int
) -> World:
    """The world of a box, given by name, path or value, whose reports can be inverted at rate ``p``.

    What a modality in words tells; None means the default of studies, and ``outcome-only`` makes it blind.
    """
    check_whole("max_steps", max_steps, 1, LONGEST_TRIAL)
    acting = replace(flip, p=p) if isinstance(flip, OutcomeFlip) else flip_of(flip, p)
    if not isinstance(modality, str | None):
        raise BadValue("modality", modality, "a text, such as symbolic")
    told = blind(modality or "symbolic") if flip == "outcome-only" else modality or STATES
    channel = shown(told)
    if (source := source_of(told)) not in (None, "truth"):
        raise BadValue("modality", told, f"symbolic without source={source}, whose errors only a plant makes")
    if not isinstance(channel, TextChannel):
        known = "symbolic, or symbolic?tell=state, as which a viewer that sees well plays in pictures"
        raise BadValue("modality", told, known)
    acting.check_told(told, both=channel.tell == "both")
    found = find_box(box)
    return World(box=found, space=space_of(found), flip=acting, budget=max_steps, tell=channel.tell)


def policy_of(agent: str | Policy[Any]) -> Policy[Any]:
    """The policy with a spec; an agent whose memory is not one value is refused."""
    if isinstance(agent, str):
        allow(agent)
    found = resolve(agent).make() if isinstance(agent, str) else agent
    if not isinstance(found, Policy):
        raise BadValue("agent", agent, "one whose whole memory is one value: a strategy or a cognitive model")
    return found


def flip_alone(acting: Sequence[Intervention], plant: str) -> OutcomeFlip | None:
    """The flip of all reports alike, at rate 0 without one, if nothing else acts in trials in words on this plant.

    With it the rules of the box and the law of false reports are the whole trial; None if they are not.
    """
    flips = (one for one in acting if type(one) is OutcomeFlip and one == one.at_rate(one.p))
    flip = next(flips, OutcomeFlip())
    alone = all(one is flip or type(one) is TextChannel for one in acting)
    return flip if alone and plant == "symbolic" else None


class Boxes:
    """Boxes of one structure, one a row: where their joints are, and what was told last.

    Attributes:
        configuration: True positions in panel order, shape (rows,).
        positions: The same in the order of each row's listing.
        told: The positions told last, in that order; if nothing is told of them, what would have been.
    """

    def __init__(self, may_move: Flags, start: int, flip: OutcomeFlip, orders: Whole) -> None:
        self._may_move, self._start, self._flip, self._orders = may_move, start, flip, orders
        self.configuration, self.positions, self.told = np.empty((3, len(orders)), np.int64)
        self.begin(np.arange(len(orders)), orders)

    def begin(self, rows: Whole, orders: Whole) -> None:
        """Begin a trial in some rows: the joints, by index in panel order, as it lists them, shape (rows, joints)."""
        self._orders[rows] = orders
        self.configuration[rows] = self._start
        self.positions[rows] = self.told[rows] = (self._start >> orders & 1) @ (1 << np.arange(orders.shape[-1]))

    def attempt(self, rows: Whole, places: Whole, drawn: NDArray[np.float64]) -> tuple[Whole, Flags, Flags]:
        """Attempt the joint at a place of the listing in some rows.

        ``drawn`` are the random numbers of the reports, as :meth:`OutcomeFlip.lasting` takes them.

        Returns:
            The joint by index in panel order, whether it moved, and the told outcome.
        """
        joints, bits = self._orders[rows, places], 1 << places
        before = self.configuration[rows]
        moved = self._may_move[before, joints]
        self.configuration[rows] = before ^ (moved << joints)
        self.positions[rows] = now = self.positions[rows] ^ moved * bits
        outcome, self.told[rows] = self._flip.report(now, self.told[rows], bits, moved, drawn)
        return joints, moved, outcome


class Minds:
    """The memories that a policy has had so far, by number: what each chooses, and what reports make of it.

    Many trials share a memory, so the policy is asked once for all of them.

    ``policy`` is what it is asked, ``world`` where it plays.
    """

    def __init__(self, policy: Policy[Any], world: World) -> None:
        self.policy, self.world, self._joints = policy, world, world.space.joints
        self._minds: list[tuple[View, Hashable]] = []
        self._chances: list[tuple[float, ...]] = []  # of each joint
        self._numbers: dict[tuple[View, Hashable], int] = {}
        self._after: dict[int, int] = {}
        self._claims: dict[int, Outcome | None] = {}

    def begin(self, orders: Whole) -> Whole:
        """The mind before the first step of each row. Of many trials before, those of which no trial goes on may go."""
        if len(self._minds) > _MOST:
            for known in (self._minds, self._chances, self._numbers, self._after, self._claims):
                known.clear()
        panel = self.policy.heeds_panel
        seen = orders if panel else np.argmax(orders == self.world.space.target, axis=1)[:, None]
        _, first, rows = np.unique(seen, axis=0, return_index=True, return_inverse=True)
        views = [self.world.view(tuple(order), panel=panel) for order in orders[first].tolist()]
        begun = np.array([self._number(view, self.policy.begin(view)) for view in views])
        return begun[rows.reshape(-1)]

    def _number(self, view: View, memory: Hashable) -> int:
        number = self._numbers.setdefault((view, memory), len(self._minds))
        if number == len(self._minds):
            self._minds.append((view, memory))
            self._chances.append(self.policy.chances(view, memory))
        return number

    def chances(self, minds: Whole) -> NDArray[np.float64]:
        """The probability with which each mind attempts each place in the listing, shape (minds, joints)."""
        return np.array([self._chances[mind] for mind in minds.tolist()]).reshape(-1, self._joints)

    def choose(self, minds: Whole, luck: NDArray[np.float64]) -> Whole:
        """The place in the listing that each row attempts, given a random number for each."""
        kinds, rows = np.unique(minds, return_inverse=True)
        sums = np.array([running_sums(self._chances[kind]) for kind in kinds.tolist()])
        return np.asarray((luck[:, None] >= sums[rows]).sum(axis=1))

    def remember(self, minds: Whole, places: Whole, moved: Flags, shifted: Whole) -> Whole:
        """The minds after reports: whether the joint moved as told, and the joints told away from their start."""
        heard = self._report(minds, places, moved, shifted)
        _, first, rows = np.unique(heard, return_index=True, return_inverse=True)
        reports = (one[first].tolist() for one in (heard, minds, places, moved, shifted))
        for report, mind, joint, said, away in zip(*reports, strict=True):
            if report not in self._after:
                view, memory = self._minds[mind]
                shown = None if self.world.tell == "outcome" else away
                told = Told(joint=joint, moved=said, shifted=shown, states_only=self.world.states_only)
                after = self.policy.remember(view, memory, told)
                self._after[report] = self._number(view, after)
                self._claims[report] = self.policy.claim(after, told)
        return np.array([self._after[report] for report in heard[first].tolist()], np.int64)[rows]

    def claim(self, mind: int, place: int, moved: bool, shifted: int) -> Outcome | None:
        """What is said, after a report that a mind remembered, of the attempt that it is of."""
        return self._claims[self._report(mind, place, moved, shifted)]

    def _report(self, minds: Any, places: Any, moved: Any, shifted: Any) -> Any:
        """A report as a number, or reports as an array, with the mind that gets it."""
        return ((minds * self._joints + places) * 2 + moved << self._joints) + shifted


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """The outcomes of many trials of one agent under one condition; columns have one row per trial.

    Attributes:
        solved, steps: Whether the target moved, and the steps played, shape (trials,).
        actions: Joints attempted, by index in panel order, -1 after the end, shape (trials, budget).
        moved, told_moved: Whether each joint moved, and is reported to have, the same shape; False after the end.
        world: The box, its reports and the budget.
    """

    solved: Flags
    steps: NDArray[np.int32]
    actions: NDArray[np.int8]
    moved: Flags
    told_moved: Flags
    world: World

    def __len__(self) -> int:
        return len(self.solved)

    @property
    def success(self) -> float:
        """Share of trials solved, [0, 1]."""
        return float(self.solved.mean())

    @property
    def curve(self) -> NDArray[np.float64]:
        """Share of trials solved by step 0, 1, ..., shape (budget + 1,)."""
        ends = np.bincount(self.steps[self.solved], minlength=self.world.budget + 1)
        return np.asarray(np.cumsum(ends) / len(self), np.float64)

    def loops(self) -> NDArray[np.bool_]:
        """Whether each trial holds an action loop."""
        onsets = onset_batch(self.actions)
        return (onsets > 0) & (onsets <= self.steps)


def population(
    agent: str | Policy[Any] = "random",
    box: str | Path | Lockbox = DEFAULT_BOX,
    *,
    p: float = 0.0,
    flip: FlipKind | OutcomeFlip = DEFAULT,
    modality: str | None = None,
    trials: int = 5_000,
    seed: int = 1,
    repetition: int = 1,
    max_steps: int = 20,
) -> Population:
    """Play many trials of one agent under one condition: precise curves need thousands of trials per point.

    Trial i equals ``run_trial(..., trial=i)``, action by action and report by report (rows start at 0, trials at 1).
    The layout of the panel is fixed, and labels are drawn in every trial.

    >>> population("round-robin", trials=100).success
    1.0

    Args:
        agent: Spec of an agent that is a policy, or a policy.
        box: Name of a box, path of a TOML file, or a box.
        p: Flip probability, [0, 1].
        flip: What a false report is: a word, or a flip of every report, whose rate does not count.
        modality: As for :func:`lockprobe.propagate`: ``symbolic?tell=state``, or ``symbolic``, with outcomes too.
        trials: Number of trials.
        seed: Seed of the study.
        repetition: Repetition of the study, from 1.
        max_steps: Budget in steps.
    """
    check_whole("trials", trials, 1)
    check_whole("repetition", repetition, 1)
    check_whole("seed", seed, 0)
    policy, world = policy_of(agent), world_of(box, flip, p, modality, max_steps)
    if world.flip != world.flip.at_rate(p):
        raise BadValue("flip", flip, "a flip of every report; propagate takes one of some reports too")
    if trials * max_steps > MOST_STEPS:
        raise BadValue("steps of all trials", trials * max_steps, f"at most {MOST_STEPS}")
    shape = (trials, max_steps)
    found = Population(
        solved=np.zeros(trials, bool),
        steps=np.full(trials, max_steps, np.int32),
        actions=np.full(shape, -1, np.int8),
        moved=np.zeros(shape, bool),
        told_moved=np.zeros(shape, bool),
        world=world,
    )
    for first in range(1, trials + 1, PIECE):
        now = np.arange(first, min(first + PIECE, trials + 1))
        luck = partial(numbers, world.box.name, "labels", seed=seed, repetition=repetition, trial=now)
        orders = drawn_orders(luck(places=2 * world.space.joints))[1]
        for step, one in enumerate(played(Minds(policy, world), orders, seed, np.full_like(now, repetition), now), 1):
            at = (now[one.rows] - 1, step - 1)
            found.actions[at], found.moved[at], found.told_moved[at] = one.joints, one.moved, one.said
            found.solved[at[0][one.done]], found.steps[at[0][one.done]] = True, step
    return found


class StepOfMany(NamedTuple):
    """One step of those trials that still run; columns have one entry for each of them.

    Attributes:
        rows: Which trials these are, by their place among all.
        minds: The mind that chose, by number, and ``places`` what it chose in the listing.
        joints, moved, done: The joint by index in panel order, whether it moved, and whether that solved the box.
        said: Whether it is told to have moved, also as positions imply it.
        told: The positions told, in the order of the listing, or what would have been told of them.
        away: Those of them that are told away from where they started.
        falsely: Whether the report tells anything but the truth.
    """

    rows: Whole
    minds: Whole
    places: Whole
    joints: Whole
    moved: Flags
    done: Flags
    said: Flags
    told: Whole
    away: Whole
    falsely: Flags


def played(minds: Minds, orders: Whole, seed: int, repetition: Whole, trial: Whole) -> Iterator[StepOfMany]:
    """Play the trials with these numbers; ``orders`` are the joints as each lists them, shape (trials, joints)."""
    world, rows = minds.world, np.arange(len(trial))
    flip, space, count = world.flip, world.space, world.flip.numbers(world.space.joints)
    boxes = Boxes(space.may_move, space.start, flip, orders.copy())
    start, mind = boxes.told.copy(), minds.begin(orders)
    chances, drawn = np.empty((0, len(trial))), np.empty((0, len(trial), count))
    for step in range(1, world.budget + 1):
        if not len(chances):  # few trials draw for many steps at once
            ahead = np.arange(step, min(step + max(1, PIECE // rows.size), world.budget + 1))[:, None]
            luck = partial(
                numbers, world.box.name, seed=seed, repetition=repetition[rows], trial=trial[rows], step=ahead
            )
            chances, drawn = luck("agent")[..., 0], np.ones((len(ahead), rows.size, count))
            if flip.p:
                drawn = luck(f"{flip.stream}-0", places=count)
        places, last = minds.choose(mind, chances[0]), boxes.told[rows]
        joints, moved, outcome = boxes.attempt(rows, places, drawn[0].T)
        told, done = boxes.told[rows], moved & (joints == space.target)
        said = ((told ^ last) >> places & 1).astype(bool) if world.states_only else outcome
        falsely = (told != boxes.positions[rows]) & (world.tell != "outcome")
        falsely |= (outcome != moved) & (not world.states_only)
        away = told ^ start[rows]
        yield StepOfMany(rows, mind, places, joints, moved, done, said, told, away, falsely)
        on = ~done
        rows, chances, drawn = rows[on], chances[1:, on], drawn[1:, on]
        if not rows.size:
            return
        mind = minds.remember(mind[on], places[on], said[on], away[on])
