"""Which boxes somebody plays who joins now, and in which order.

Conditions are balanced: over all who take part none is played by more than one person more than another, as long as
there are trials left of each. Orders are the rows of a Williams square: in every so many people each condition stands
once in each place, and comes equally often after each other. Nobody meets the same luck (repetition and trial) twice,
since labels, layout and flips would be the same again. All follows from the study's seed and from what is taken.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache

import numpy as np
from scipy.optimize import linear_sum_assignment

from lockprobe.options import PEOPLE
from lockprobe.people.diary import Slot
from lockprobe.people.experiment import Experiment
from lockprobe.seeds import generator
from lockprobe.studies.study import Study

__all__ = ["Condition", "assigned", "boxes_each", "conditions_of", "slots_of", "williams"]

Condition = tuple[float, str]
"""Flip probability and modality."""

Luck = tuple[int, int]
"""Repetition and trial."""

_CLOSED = 1e12
"""The price of a trial that is taken."""


def conditions_of(study: Study) -> tuple[Condition, ...]:
    """The conditions that people play."""
    return tuple((p, modality) for modality in study.modalities_of(PEOPLE) for p in study.p)


def slots_of(study: Study) -> Iterable[Slot]:
    """All trials that people play, in the order of the study."""
    for plan in study.plans(PEOPLE):
        yield Slot(p=plan.p, modality=plan.modality, repetition=plan.repetition, trial=plan.trial)


def boxes_each(study: Study, experiment: Experiment) -> int:
    """How many boxes a participant plays as long as there are enough: never more than there is luck for.

    >>> from lockprobe.lockbox.families import box
    >>> study = Study(name="flips", agents=("participant",), box=box("chain-4"), p=(0.0, 0.4), trials=5, repetitions=1)
    >>> boxes_each(study, Experiment()), boxes_each(study, Experiment(design="between", trials_each=9))
    (2, 5)
    """
    asked = experiment.trials_each or (len(conditions_of(study)) if experiment.design == "within" else 1)
    return min(asked, study.repetitions * study.trials)


def assigned(
    study: Study, experiment: Experiment, before: Sequence[Sequence[Slot]], taken: Collection[Slot]
) -> tuple[Slot, ...]:
    """The trials of somebody who joins now, in the order in which they are played.

    Args:
        study: The study.
        experiment: How people take part.
        before: The trials of everybody who takes part or has, in their order.
        taken: Trials that cannot be given: finished, or somebody plays them.

    Returns:
        So many as :func:`boxes_each` says; fewer where no more are left, and none where none is.
    """
    conditions = conditions_of(study)
    left = Counter(dict.fromkeys(conditions, study.repetitions * study.trials))
    left.subtract((slot.p, slot.modality) for slot in set(taken))
    orders = [[(slot.p, slot.modality) for slot in slots] for slots in before]
    length = boxes_each(study, experiment)
    if experiment.design == "between":
        order = _one(conditions, length, orders, left)
    else:
        order = _each(conditions, length, orders, left, study.seed)
    return _with_luck(order, study, taken)


def _one(
    conditions: Sequence[Condition], length: int, before: Sequence[Sequence[Condition]], left: Counter[Condition]
) -> list[Condition]:
    """The condition that fewest have, of those of which most is left up to the length asked for."""
    people = Counter(order[0] for order in before if order)
    found = min(conditions, key=lambda one: (-min(left[one], length), people[one]))
    return [found] * min(length, left[found])


def _each(
    conditions: Sequence[Condition],
    length: int,
    before: Sequence[Sequence[Condition]],
    left: Counter[Condition],
    seed: int,
) -> list[Condition]:
    """Every condition equally often, as far as the length goes; the rest from those that were played least."""
    size = len(conditions)
    shuffled = [conditions[i] for i in generator(seed, "people", "orders").permutation(size)]
    rows = [[shuffled[i] for i in row] for row in williams(size)]
    used = [sum(list(order[:size]) == row for order in before) for row in rows]
    first = used.index(min(used))
    order = [condition for block in range(length // size) for condition in rows[(first + block) % len(rows)]]
    order = [condition for n, condition in enumerate(order) if order[:n].count(condition) < left[condition]]
    played = Counter(condition for earlier in before for condition in earlier)
    rest = _least(shuffled, length - len(order), played + Counter(order), left - Counter(order))
    return [*order, *_in_places(rest, [list(earlier[len(order) :]) for earlier in before])]


def _least(
    conditions: Sequence[Condition], count: int, played: Counter[Condition], left: Counter[Condition]
) -> list[Condition]:
    """So many conditions that were played least, one after the other, as long as any are left."""
    found: Counter[Condition] = Counter()
    for _ in range(count):
        open_ones = [one for one in conditions if left[one] > found[one]]
        if not open_ones:
            break
        found[min(open_ones, key=lambda one: (found[one] + played[one], conditions.index(one)))] += 1
    return list(found.elements())


def _in_places(rest: list[Condition], before: Sequence[Sequence[Condition]]) -> list[Condition]:
    """The same in such an order that each stands where it has stood least before."""
    if not rest:
        return []
    stood = Counter((place, condition) for order in before for place, condition in enumerate(order))
    price = np.array([[stood[place, condition] for condition in rest] for place in range(len(rest))], dtype=float)
    return [rest[i] for i in linear_sum_assignment(price)[1].tolist()]


def _with_luck(order: Sequence[Condition], study: Study, taken: Collection[Slot]) -> tuple[Slot, ...]:
    """A different luck for each place of an order, from what is free.

    Luck that is left in most conditions goes first: then what is left in the end can still be given to somebody.
    """
    if not order:
        return ()
    closed = {(slot.p, slot.modality, slot.repetition, slot.trial) for slot in taken}
    gone = Counter((slot.repetition, slot.trial) for slot in set(taken))
    conditions = len(conditions_of(study))
    lucks = [
        (repetition, trial)
        for repetition in range(1, study.repetitions + 1)
        for trial in range(1, study.trials + 1)
        if gone[repetition, trial] < conditions
    ]
    ahead = {luck: n for n, luck in enumerate(sorted(lucks, key=lambda luck: (gone[luck], luck)))}
    price = np.array(
        [[_CLOSED if (*condition, *luck) in closed else float(ahead[luck]) for luck in lucks] for condition in order]
    ).reshape(len(order), len(lucks))
    places, chosen = (indices.tolist() for indices in linear_sum_assignment(price))
    return tuple(
        Slot(p=order[place][0], modality=order[place][1], repetition=lucks[at][0], trial=lucks[at][1])
        for place, at in zip(places, chosen, strict=True)
        if price[place, at] < _CLOSED
    )


@lru_cache(maxsize=32)
def williams(size: int) -> tuple[tuple[int, ...], ...]:
    """Orders of so many things, each of which stands once in every place and comes equally often after each other.

    >>> williams(4)
    ((0, 1, 3, 2), (1, 2, 0, 3), (2, 3, 1, 0), (3, 0, 2, 1))

    Returns:
        So many rows, and where their number is odd twice as many: the second half is the first read backwards.
    """
    first = [0] + [(n + 1) // 2 if n % 2 else size - n // 2 for n in range(1, size)]
    square = [tuple((place + shift) % size for place in first) for shift in range(size)]
    backwards = [row[::-1] for row in square] if size % 2 and size > 1 else []
    return (*square, *backwards)
