"""Assignment: which boxes a new participant plays, in balanced order.

While nobody drops out and trials remain, the numbers of participants per condition differ by at most one. Orders are
rows of a Williams square: in each block of participants every condition takes each position once and follows every
other condition equally often. Among rows used equally often, the least played boxes decide. Where people play only
some conditions, the least played ones come first, which compensates for dropouts. Nobody plays the same repetition and
trial twice, because labels, layout and flips would repeat, nor a box again before they have played all: every box takes
each position and each condition about equally often. The assignment depends only on the study's seed and on the
trials given out or taken.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from math import ceil

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.diary import Slot
from lockprobe.people.experiment import Experiment
from lockprobe.studies.study import Study

Luck = tuple[int, int]
"""Repetition and trial."""

Rests = Counter[tuple[str, ...]]
"""Orders beyond whole rows of the square, and how many participants got each."""

_CLOSED, _AGAIN, _PAIRED = 1e12, 1e9, 1e4
"""The costs of a trial that is taken, of a box that somebody plays again, and of one more trial of a box and a
condition, beside which one more of a box and a position costs 1."""


def conditions_of(study: Study) -> tuple[str, ...]:
    """The conditions that people play."""
    return tuple(one.label for one in study.conditions_of(PEOPLE))


def boxes_each(study: Study, experiment: Experiment) -> int:
    """How many boxes a participant plays while enough are left: at most one per repetition and trial.

    >>> from lockprobe.interventions.conditions import flips
    >>> from lockprobe.boxes.families import box
    >>> conditions = flips((0.0, 0.4))
    >>> study = Study(
    ...     name="flips", agents=("participant",), boxes=(box("chain-4"),), conditions=conditions,
    ...     trials=5, repetitions=1,
    ... )
    >>> boxes_each(study, Experiment()), boxes_each(study, Experiment(design="between", trials_each=9))
    (2, 5)
    """
    asked = experiment.trials_each or (len(conditions_of(study)) if experiment.design == "within" else 1)
    return min(asked, study.repetitions * study.trials)


def trials_for(people: int, conditions: int, repetitions: int, experiment: Experiment) -> int:
    """Trials per condition and repetition that give this many people places.

    >>> trials_for(40, 4, 1, Experiment()), trials_for(40, 4, 1, Experiment(design="between"))
    (40, 10)
    """
    if experiment.design == "between":
        boxes = experiment.trials_each or 1
        luck = ceil(people / conditions) * boxes
    else:
        boxes = experiment.trials_each or conditions
        luck = max(boxes, ceil(people * boxes / conditions))  # nobody meets the same luck twice
    return ceil(luck / repetitions)


@dataclass(slots=True)
class Given:
    """Running counts of the trials that were given out.

    Attributes:
        orders: Orders of conditions, and how many participants got each.
        boxes: Boxes of each condition that are played or still planned.
        taken: Trials that are finished or assigned.
        taken_of: Their number per condition.
        gone: Their number per repetition and trial.
        places: How many participants play a trial (its number, which tells its box) at a position, from 0.
    """

    orders: Counter[tuple[str, ...]] = field(default_factory=Counter)
    boxes: Counter[str] = field(default_factory=Counter)
    taken: set[tuple[str, Luck]] = field(default_factory=set)
    taken_of: Counter[str] = field(default_factory=Counter)
    gone: Counter[Luck] = field(default_factory=Counter)
    places: Counter[tuple[int, int]] = field(default_factory=Counter)

    def give(self, slots: Sequence[Slot], kept: Collection[Slot] | None = None) -> None:
        """Count a new participant's trials; ``kept`` are those finished or still planned, all if left out."""
        self.orders[tuple(slot.condition for slot in slots)] += 1
        self.places.update((position, slot.trial) for position, slot in enumerate(slots))
        kept = slots if kept is None else kept
        self.boxes.update(slot.condition for slot in kept)
        self.take(kept)

    def take(self, slots: Iterable[Slot]) -> None:
        """Trials cannot be given any more."""
        for slot in slots:
            condition, luck = slot.condition, (slot.repetition, slot.trial)
            if (condition, luck) not in self.taken:
                self.taken.add((condition, luck))
                self.taken_of[condition] += 1
                self.gone[luck] += 1


def assigned(study: Study, experiment: Experiment, given: Given) -> tuple[Slot, ...]:
    """The trials of a participant who joins now, in order.

    Their number is :func:`boxes_each`; smaller where fewer are left.
    """
    conditions = conditions_of(study)
    left = Counter({one: study.repetitions * study.trials - given.taken_of[one] for one in conditions})
    length = boxes_each(study, experiment)
    if experiment.design == "between":
        order = _one(conditions, length, given, left)
    else:
        order = _each(conditions, length, given, left, study.seed)
    return _with_luck(order, study, given)


def _one(conditions: Sequence[str], length: int, before: Given, left: Counter[str]) -> list[str]:
    """The condition of which fewest boxes were played, of those of which most is left up to the length asked for."""
    people: Counter[str] = Counter()
    for order, number in before.orders.items():
        if order:
            people[order[0]] += number
    found = min(conditions, key=lambda one: (-min(left[one], length), before.boxes[one], people[one]))
    return [found] * min(length, left[found])


def _each(conditions: Sequence[str], length: int, before: Given, left: Counter[str], seed: int) -> list[str]:
    """Every condition equally often, as far as the length goes; the rest from those that were played least."""
    size = len(conditions)
    shuffled = [conditions[i] for i in generator(seed, "people", "orders").permutation(size)]
    rows = [[shuffled[i] for i in row] for row in williams(size)]
    used = [sum(n for order, n in before.orders.items() if list(order[:size]) == row) for row in rows]
    start = min(range(len(rows)), key=lambda n: (used[n], [before.boxes[condition] for condition in rows[n]]))
    order = [condition for block in range(length // size) for condition in rows[(start + block) % len(rows)]]
    order = [condition for n, condition in enumerate(order) if order[:n].count(condition) < left[condition]]
    rests: Rests = Counter()
    for earlier, number in before.orders.items():
        rests[earlier[len(order) :]] += number
    rest = _least(shuffled, length - len(order), Counter(order), before.boxes, rests, left)
    return [*order, *_in_places(rest, rests)]


def _least(
    conditions: Sequence[str],
    count: int,
    theirs: Counter[str],
    boxes: Counter[str],
    rests: Rests,
    left: Counter[str],
) -> list[str]:
    """Up to ``count`` more conditions for a participant who already has ``theirs``, least played (``boxes``) first.

    Ties go to the condition that others (``rests``) got least often together with those already found. ``left`` counts
    the free trials per condition.
    """
    found: Counter[str] = Counter()
    for _ in range(count):
        have = theirs + found
        open_ones = [one for one in conditions if left[one] > have[one]]
        if not open_ones:
            break
        together: Counter[str] = Counter()
        for rest, number in rests.items():
            for one in rest:
                together[one] += number * sum(other in rest for other in found)
        found[min(open_ones, key=lambda one: (have[one], boxes[one], together[one]))] += 1
    return list(found.elements())


def _in_places(rest: list[str], before: Rests) -> list[str]:
    """Order conditions so that each takes the position that it has had least often."""
    if not rest:
        return []
    from scipy.optimize import linear_sum_assignment

    stood: Counter[tuple[int, str]] = Counter()
    for order, number in before.items():
        for at in enumerate(order):
            stood[at] += number
    price = np.array([[stood[place, condition] for condition in rest] for place in range(len(rest))], dtype=float)
    return [rest[i] for i in linear_sum_assignment(price)[1].tolist()]


def _with_luck(order: Sequence[str], study: Study, given: Given) -> tuple[Slot, ...]:
    """A different repetition and trial for each position of an order, from what is free, on different boxes.

    Those that are free in most conditions are used first, so that the last ones still fit another participant.
    """
    if not order:
        return ()
    from scipy.optimize import linear_sum_assignment

    gone, size = given.gone, len(conditions_of(study))
    trials, boxes = range(1, study.trials + 1), len(study.boxes)
    lucks = [one for one in product(range(1, study.repetitions + 1), trials) if gone[one] < size]
    box_of = np.array([trial % boxes for _, trial in lucks], dtype=int)
    taken = np.array([[(one, luck) in given.taken for luck in lucks] for one in order]).reshape(len(order), len(lucks))
    paired = Counter((one, trial % boxes) for one, (_, trial) in given.taken)
    placed: Counter[tuple[int, int]] = Counter()
    for (position, trial), number in given.places.items():
        placed[position, trial % boxes] += number
    price = np.array(
        [
            [
                _AGAIN * again
                + _PAIRED * paired[one, of]
                + placed[position, of]
                + _CLOSED * taken[position, box_of == of].all()
                for again in range(ceil(len(order) / boxes))
                for of in range(boxes)
            ]
            for position, one in enumerate(order)
        ]
    )
    theirs = linear_sum_assignment(price)[1] % boxes
    ahead = np.argsort(np.argsort([gone[luck] for luck in lucks], kind="stable"), kind="stable").astype(float)
    cost = np.where(taken, _CLOSED, ahead + _AGAIN * (box_of != theirs[:, None]))
    found = zip(*(at.tolist() for at in linear_sum_assignment(cost)), strict=True)
    return tuple(
        Slot(condition=order[position], repetition=lucks[at][0], trial=lucks[at][1])
        for position, at in found
        if not taken[position, at]
    )


@lru_cache(maxsize=32)
def williams(size: int) -> tuple[tuple[int, ...], ...]:
    """Orders of ``size`` things: each takes every position once and follows each other equally often.

    >>> williams(4)
    ((0, 1, 3, 2), (1, 2, 0, 3), (2, 3, 1, 0), (3, 0, 2, 1))

    Returns:
        ``size`` rows; twice as many where ``size`` is odd, the second half being the first in reverse.
    """
    first = [0] + [(n + 1) // 2 if n % 2 else size - n // 2 for n in range(1, size)]
    square = [tuple((place + shift) % size for place in first) for shift in range(size)]
    backwards = [row[::-1] for row in square] if size % 2 and size > 1 else []
    return (*square, *backwards)
