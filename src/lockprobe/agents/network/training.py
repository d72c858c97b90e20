"""Training of a learner by imitation: the targets are the best next joints, on random boxes, in its own trials.

Each update plays a batch of new boxes. In every step the network's target is the uniform distribution over the joints
that open the box in the fewest steps. The network cannot know these joints, so it learns to infer them from earlier
reports (decision pretraining: Lee et al. 2023, arXiv:2306.14892). Some actions are random, so that training covers
states that the network would avoid. The optimiser is Adam; its learning rate falls over the second half of the
schedule.

Parameters are rounded after each update, for reproducibility: processors differ in the last bits of products, and
without rounding such differences would grow from update to update. So one command gives one file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.network.boxes import Boxes, copies, random_boxes
from lockprobe.agents.network.network import HIDDEN, Network, StepActivations, encoded, gradient, initial
from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.validation import check_whole

__all__ = ["MOST_UPDATES", "SCHEDULE", "PlayedTrials", "TrainingSettings", "play", "success", "train"]

SCHEDULE = 900
"""Updates of the whole schedule."""

MOST_UPDATES = 100_000
"""The most updates of a schedule."""

BATCH, BUDGET, RATE = 256, 20, 4e-3
"""Boxes of an update, steps of a trial, and Adam's step size before it falls."""

RANDOM_AT_FIRST, RANDOM_LATER = 0.3, 0.1
"""Share of random actions in the first third of the schedule, and after it."""

_GRID = 2.0**-20
"""Parameters are multiples of this."""

_FADES = (0.9, 0.999)

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingSettings:
    """The settings of a training.

    Attributes:
        updates: Number of updates, from 1 to :attr:`schedule`.
        joints: Joints of the boxes, from 2 to 8.
        hidden: Number of hidden units, from 1 to 256.
        seed: Seed of the weights, the boxes and the actions.
        told_lies: Whether reports are false at a rate drawn from [0, 1] for each update; else all are true.
        schedule: Number of updates over which the learning rate and the share of random actions fall.
        box: The only box, with its joints in a random order each time; None for random boxes.

    Raises:
        BadValue: If a number is out of range.
    """

    updates: int
    joints: int = 4
    hidden: int = HIDDEN
    seed: int = 1
    told_lies: bool = False
    schedule: int = SCHEDULE
    box: Lockbox | None = None

    def __post_init__(self) -> None:
        check_whole("schedule", self.schedule, 1, MOST_UPDATES)
        if not 1 <= self.updates <= self.schedule:
            raise BadValue("updates", self.updates, f"a whole number from 1 to the schedule's {self.schedule}")
        if self.box is not None and len(self.box.names) != self.joints:
            raise BadValue("joints", self.joints, f"the {len(self.box.names)} joints of {self.box.name}")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayedTrials:
    """The finished trials of a network on a batch of boxes.

    Attributes:
        solved: Whether each box was opened, shape (trials,).
        steps: Steps played, shape (trials,).
        actions: Joints attempted, -1 after the end, shape (trials, budget).
    """

    solved: NDArray[np.bool_]
    steps: NDArray[np.int64]
    actions: NDArray[np.int64]


def train(settings: TrainingSettings) -> Iterator[Network]:
    """Yield the network after every update; reproducible on every machine, up to rare rounding differences."""
    network = initial(settings.joints, settings.hidden, settings.seed)
    means, squares = ({name: np.zeros_like(a) for name, a in network.arrays().items()} for _ in range(2))
    for update in range(1, settings.updates + 1):
        slope = _gradient_of_update(network, settings, update)
        rate = RATE * min(1.0, 2 * (1 - (update - 1) / settings.schedule))
        moved = {}
        for name, array in network.arrays().items():
            means[name] += (1 - _FADES[0]) * (slope[name] - means[name])
            squares[name] += (1 - _FADES[1]) * (slope[name] ** 2 - squares[name])
            mean = means[name] / (1 - _FADES[0] ** update)
            square = squares[name] / (1 - _FADES[1] ** update)
            moved[name] = np.round((array - rate * mean / (np.sqrt(square) + 1e-8)) / _GRID) * _GRID
        network = Network(**moved)
        yield network


def _gradient_of_update(network: Network, settings: TrainingSettings, update: int) -> dict[str, Array]:
    """The gradient of one update's loss: mean cross-entropy over the steps of its trials."""
    rng = generator(settings.seed, "learner", "update", update)
    drawn = random_boxes(BATCH, settings.joints, rng) if settings.box is None else copies(settings.box, BATCH, rng)
    rate = float(rng.random()) if settings.told_lies else 0.0
    chance = RANDOM_AT_FIRST if update <= settings.schedule / 3 else RANDOM_LATER
    trials = _TrialBatch(drawn, network, p=rate, rng=rng)
    steps, errors = [], []
    for _ in range(BUDGET):
        steps.append(trials.read())
        best = drawn.best(trials.state)
        aim = best / np.maximum(best.sum(axis=1, keepdims=True), 1)
        errors.append(np.where(trials.running[:, None], _softmax(trials.logits, 1.0) - aim, 0.0))
        trials.act(temperature=1.0, random=chance)
    made = sum(float((error != 0).any(axis=1).sum()) for error in errors)
    return gradient(network, steps, [error / made for error in errors]).arrays()


class _TrialBatch:
    """A batch of trials during play."""

    def __init__(self, boxes: Boxes, network: Network, *, p: float, rng: np.random.Generator) -> None:
        number, self._boxes, self._network, self._p, self._rng = len(boxes), boxes, network, p, rng
        self.state = np.zeros(number, dtype=np.int64)
        self.running = np.ones(number, dtype=np.bool_)
        self.logits = np.zeros((number, boxes.joints))
        self.attempted = np.full(number, -1)
        self._moved = np.zeros(number)
        self._shown = self.state
        self._hidden = np.zeros((number, network.hidden))

    def read(self) -> StepActivations:
        """Read the last report; returns the activations for backpropagation."""
        positions = ((self._shown[:, None] >> np.arange(self._boxes.joints)) & 1).astype(np.float64)
        step = self._network.step(encoded(self.attempted, self._moved, positions, self._boxes.target), self._hidden)
        self._hidden = step.after
        self.logits = self._network.logits(step.after)
        return step

    def act(self, *, temperature: float, random: float = 0.0) -> None:
        """Attempt a joint in every trial, and receive the reports."""
        number, joints = self.logits.shape
        luck = self._rng.random((number, 4))
        chances = np.cumsum(_softmax(self.logits, temperature), axis=1)
        own = np.minimum((luck[:, :1] >= chances).sum(axis=1), joints - 1)
        joint = np.where(luck[:, 1] < random, (luck[:, 2] * joints).astype(np.int64), own)
        moves = np.take_along_axis(self._boxes.moves(self.state), joint[:, None], axis=1)[:, 0]
        false = luck[:, 3] < self._p
        self.running = self.running & ~(moves & (joint == self._boxes.target))
        self.state = np.where(self.running & moves, self.state ^ (1 << joint), self.state)
        told = moves ^ false
        place = 1 << joint
        self._shown = (self.state & ~place) | ((self._shown & place) ^ np.where(told, place, 0))
        self._moved = np.where(told, 1.0, -1.0)
        self.attempted = joint


def play(
    network: Network,
    boxes: Boxes,
    *,
    p: float = 0.0,
    temperature: float = 1.0,
    budget: int = BUDGET,
    seed: int = 1,
) -> PlayedTrials:
    """Play every box once with reports of positions (``symbolic?tell=state``) and flips of the default reading.

    Args:
        network: The network.
        boxes: Boxes with the network's number of joints.
        p: Flip probability, [0, 1].
        temperature: Softmax temperature of the choice; 0 takes the most probable joint.
        budget: Budget in steps.
        seed: Seed of choices and flips.
    """
    trials = _TrialBatch(boxes, network, p=p, rng=generator(seed, "learner", "play"))
    actions = np.full((len(boxes), budget), -1)
    for step in range(budget):
        running = trials.running
        trials.read()
        trials.act(temperature=temperature)
        actions[running, step] = trials.attempted[running]
        if not trials.running.any():
            break
    return PlayedTrials(solved=~trials.running, steps=(actions >= 0).sum(axis=1), actions=actions)


def success(
    network: Network, *, boxes: int = 10_000, temperature: float = 1.0, seed: int = 1, only: Lockbox | None = None
) -> float:
    """The share of test boxes that a network opens within the budget with true reports.

    The boxes are random and used in no training, or they are copies of one box with their joints in a random order.
    """
    rng = generator(seed, "learner", "unseen boxes")
    drawn = random_boxes(boxes, network.joints, rng) if only is None else copies(only, boxes, rng)
    return float(play(network, drawn, temperature=temperature, seed=seed).solved.mean())


def _softmax(logits: Array, temperature: float) -> Array:
    """Probabilities of joints, shape (trials, n); at temperature 0 the first most probable joint has all."""
    if temperature == 0:
        found: Array = np.eye(logits.shape[1])[logits.argmax(axis=1)]
        return found
    raised = np.exp((logits - logits.max(axis=1, keepdims=True)) / temperature)
    return np.asarray(raised / raised.sum(axis=1, keepdims=True))
