"""The choices of one agent's trials as arrays, with the information that the agent had.

What the agent chose may differ from what was attempted, and a report may be missing; models know both, as policies do.

Joints are places in the listing, as for :class:`lockprobe.agents.policy.Policy`. Boxes with fewer joints than the
largest are padded with joints that are not ``present``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.policy import Policy, Told, View, opened_after
from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.delay import Delay
from lockprobe.trial.record import Step, Trial

__all__ = ["WINDOW", "Choices", "Heard", "choices_of", "cluster_of", "hear", "rule"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

Memory = TypeVar("Memory")

WINDOW = 3
"""Reported attempts that are kept for models that look back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """One trial as a policy would have experienced it: the task, its choices and the reports.

    Attributes:
        view: The task in numbers.
        chosen: The joint chosen in each step.
        told: The report after each step; None where nothing was reported.
    """

    view: View
    chosen: tuple[int, ...]
    told: tuple[Told | None, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """Choices with the information available before each. Arrays have the shape (choices,) or (choices, joints).

    Attributes:
        trial: The trial of each choice, from 0.
        cluster: The cluster of luck: trials of equal repetition and trial have equal labels, flips and draws; for
            people, all trials of one person.
        chosen: The joint chosen.
        done: The joint of the report after the choice; -1 if nothing was reported.
        present: Whether each joint exists.
        target: Whether each joint is the target.
        label: The label of each joint, as a place in ``labels``.
        closed: Whether each joint is reported at its start position.
        age: Steps since each joint's last failure, 0 for the step before; -1 if it never failed.
        moves: Reported moves since then.
        recent: The last reported attempts, the latest first: ``2 * joint + moved``; -1 before the first. Shape
            (choices, WINDOW).
        reported: Joints reported away from their start position, bit j for joint j; 0 where positions are not told.
        failed: Joints that failed since the last reported move, bit j for joint j.
        own: Probabilities that the agent itself recorded; zero rows unless it recorded them at every step.
        labels: All labels, in alphabetical order.
    """

    trial: Integers
    cluster: Integers
    chosen: Integers
    done: Integers
    present: Flags
    target: Flags
    label: Integers
    closed: Flags
    age: Integers
    moves: Integers
    recent: Integers
    reported: Integers
    failed: Integers
    own: Array
    labels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.chosen)

    @property
    def joints(self) -> Integers:
        """Number of joints to choose from."""
        count: Integers = self.present.sum(axis=1)
        return count

    @property
    def last(self) -> Flags:
        """Whether each joint was attempted last, as reported."""
        last: Flags = (self.recent[:, :1] >> 1) == np.arange(self.present.shape[1])
        return last

    @property
    def stayed(self) -> Flags:
        """Whether each joint was attempted last and reported to have moved."""
        return self.last & (self.recent[:, :1] & 1 > 0)

    @property
    def place(self) -> Array:
        """The relative place of each joint in the listing, from 0 (first) to 1 (last)."""
        return np.arange(self.present.shape[1]) / np.maximum(self.joints - 1, 1)[:, None]

    def at(self, rows: Flags) -> Choices:
        """A subset of the choices, by a boolean array of shape (choices,)."""
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "labels"}
        return replace(self, **{name: array[rows] if len(array) else array for name, array in arrays.items()})


def hear(trial: Trial, boxes: Mapping[str, Lockbox] | None = None) -> Heard:
    """A trial as a policy would have experienced it.

    The positions before the first step are the true ones, because channels change only reports of attempts. A policy
    can use the panel of a box in ``boxes`` (by name) if that box has the joints of the trial.
    """
    panel = [trial.labels.index(label) for label in trial.listing]
    box = (boxes or {}).get(trial.box)
    at, lag = {trial.joints[i]: place for place, i in enumerate(panel)}, _lag(trial)
    return Heard(
        view=View(
            joints=len(panel),
            target=at[trial.target],
            places=tuple(box.joints[i].place for i in panel) if box and set(box.names) == set(trial.joints) else (),
        ),
        chosen=tuple(at[step.chosen or step.joint] for step in trial.steps),
        told=tuple(
            None
            if step.told_moved is None or i < lag
            else Told(
                joint=at[trial.steps[i - lag].joint],
                moved=step.told_moved,
                shifted=_shifted(step, trial.steps[0].state, panel),
                states_only=trial.states_only,
            )
            for i, step in enumerate(trial.steps)
        ),
    )


def _lag(trial: Trial) -> int:
    """The number of attempts by which reports are late, and of which they name the joint."""
    specs = (Spec.parse(spec, "intervention") for spec in reversed(trial.specs))
    return next((int(spec.options[Delay.doses[0]]) for spec in specs if spec.full_name == Delay.name), 0)


def _shifted(step: Step, start: str, panel: Sequence[int]) -> int | None:
    if step.told_state is None or step.pictures:  # of pictures the record has the false ones only
        return None
    return sum((step.told_state[i] != start[i]) << j for j, i in enumerate(panel))


def cluster_of(trial: Trial) -> tuple[str, int, int]:
    """The cluster of a trial: its luck, or its person."""
    return (trial.player, 0, 0) if trial.player else ("", trial.repetition, trial.trial)


def choices_of(trials: Sequence[Trial], heard: Sequence[Heard]) -> Choices:
    """All choices of one agent's trials; ``heard`` holds the same trials as heard."""
    widest = max((one.view.joints for one in heard), default=0)
    rows = [row for one in heard for row in _rows(one.view.joints, one.told)]
    reports = [told for one in heard for told in one.told]
    sizes = [len(one.told) for one in heard]
    labels = tuple(sorted({label for trial in trials for label in trial.listing}))
    keys = [cluster_of(trial) for trial in trials]
    place = {key: i for i, key in enumerate(sorted(set(keys)))}
    called = [[labels.index(label) for label in trial.listing] for trial in trials]

    def each(values: object) -> Integers:
        return np.repeat(np.asarray(values, dtype=np.int64), sizes, axis=0)

    return Choices(
        trial=each(np.arange(len(trials))),
        cluster=each([place[key] for key in keys]),
        chosen=np.array([joint for one in heard for joint in one.chosen], dtype=np.int64),
        done=np.array([-1 if told is None else told.joint for told in reports], dtype=np.int64),
        present=np.arange(widest) < each([one.view.joints for one in heard])[:, None],
        target=np.arange(widest) == each([one.view.target for one in heard])[:, None],
        label=each(_filled(called, widest, -1)),
        closed=(np.array([row.opened for row in rows], dtype=np.int64)[:, None] >> np.arange(widest)) & 1 == 0,
        age=_filled([row.age for row in rows], widest, -1),
        moves=_filled([row.moves for row in rows], widest, 0),
        recent=_filled([row.recent for row in rows], WINDOW, -1),
        reported=np.array([row.reported for row in rows], dtype=np.int64),
        failed=np.array([row.failed for row in rows], dtype=np.int64),
        own=_own(trials, widest),
        labels=labels,
    )


class _Row(NamedTuple):
    """The information before one choice."""

    opened: int
    age: list[int]
    moves: list[int]
    recent: tuple[int, ...]
    reported: int
    failed: int


def _rows(joints: int, reports: Sequence[Told | None]) -> Iterator[_Row]:
    """The information before each choice of a trial, from the reports so far; none leaves it as it is."""
    known = _Row(opened=0, age=[-1] * joints, moves=[0] * joints, recent=(), reported=0, failed=0)
    for told in reports:
        yield known
        if told is None:
            continue
        age, moves = [a + (a >= 0) for a in known.age], [m + told.moved for m in known.moves]
        if not told.moved:
            age[told.joint] = moves[told.joint] = 0
        known = _Row(
            opened=opened_after(known.opened, told),
            age=age,
            moves=moves,
            recent=(2 * told.joint + told.moved, *known.recent)[:WINDOW],
            reported=told.shifted or 0,
            failed=0 if told.moved else known.failed | 1 << told.joint,
        )


def _filled(rows: Sequence[Sequence[int]], width: int, blank: int) -> Integers:
    filled = [[*row, *[blank] * (width - len(row))] for row in rows]
    return np.array(filled, dtype=np.int64).reshape(-1, width)


def _own(trials: Sequence[Trial], width: int) -> Array:
    stated = [step.decision.probabilities for trial in trials for step in trial.steps]
    if not all(stated):
        return np.empty((0, width))
    return np.array([[*(row or ()), *[0.0] * (width - len(row or ()))] for row in stated]).reshape(-1, width)


def rule(policy: Policy[Memory], heard: Sequence[Heard]) -> Array:
    """The choice probabilities of a policy that hears an agent's trials, shape (choices, joints).

    Trials share states: a state is what the policy sees and remembers, and is a number here.
    """
    states: dict[tuple[View, Memory], int] = {}
    memories: list[Memory] = []

    def state_of(view: View, memory: Memory) -> int:
        state = states.setdefault((view, memory), len(states))
        if state == len(memories):
            memories.append(memory)
        return state

    later: dict[tuple[int, Told | None, int], int] = {}
    found = []
    for one in heard:
        view, state = one.view, state_of(one.view, policy.begin(one.view))
        for joint, told in zip(one.chosen, one.told, strict=True):
            found.append(state)
            if (after := later.get((state, told, joint))) is None:
                memory = memories[state]
                after = later[state, told, joint] = state_of(
                    view,
                    policy.remember_silence(view, memory, joint)
                    if told is None
                    else policy.remember(view, memory, told),
                )
            state = after
    width = max((one.view.joints for one in heard), default=0)
    chances = [[*policy.probabilities(*state), *[0.0] * (width - state[0].joints)] for state in states]
    return np.array(chances, dtype=np.float64).reshape(-1, width)[found]
